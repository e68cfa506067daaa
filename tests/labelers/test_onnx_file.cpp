// ONNX files as they are handed to the engines, beside what protobuf itself makes of them.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/model_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

class OnnxFile : public testing::Test {
 protected:
  std::string read(const std::string& bytes, int side, const std::string& output = "") const {
    test::writeFile(scratch_ / "net.onnx", bytes);
    ModelSpec spec;
    spec.folder = scratch_.path();
    spec.file = "net.onnx";
    spec.output = output;
    spec.preprocessing.width = spec.preprocessing.height = side;
    return readOnnx(spec);
  }

  test::ScratchFolder scratch_;
};

TEST_F(OnnxFile, OfTheRightSizeIsLeftAsItIs) {
  const std::string good = test::smallOnnx(8, 4);
  EXPECT_EQ(read(good, 8), good);
  EXPECT_EQ(read(good, 0), good) << "0 asks for no size";
  EXPECT_THAT([&] { read(good, 9); }, test::FailsWith(ErrorCode::mismatch));
}

TEST_F(OnnxFile, OfAnySizeIsFixedAsProtobufWouldDoIt) {
  const auto any = [](onnx::GraphProto& graph) {
    graph.mutable_input(0)->set_doc_string("the image");
    auto* sizes = graph.mutable_input(0)->mutable_type()->mutable_tensor_type()->mutable_shape();
    sizes->mutable_dim(0)->clear_dim_value();
    sizes->mutable_dim(2)->set_dim_param("height");
    sizes->mutable_dim(2)->set_denotation("DATA_FEATURE");
    sizes->mutable_dim(3)->set_dim_value(-1);
    auto* old = graph.add_input();  // older files list weights among the inputs, too
    old->set_name("weights");
    old->mutable_type()->mutable_tensor_type()->mutable_shape()->add_dim()->set_dim_param("n");
  };
  const std::string bytes = test::smallOnnx(8, 4, any);
  onnx::ModelProto model;
  ASSERT_TRUE(model.ParseFromString(bytes));
  auto* sizes =
      model.mutable_graph()->mutable_input(0)->mutable_type()->mutable_tensor_type()->mutable_shape();
  const int fixed[] = {1, 3, 300, 300};
  for (int i = 0; i < 4; ++i) sizes->mutable_dim(i)->set_dim_value(fixed[i]);
  EXPECT_EQ(read(bytes, 300), model.SerializeAsString());
}

TEST_F(OnnxFile, GetsAnInnerValueAsAnotherOutput) {
  const std::string bytes = test::smallOnnx(8, 4);
  onnx::ModelProto model;
  ASSERT_TRUE(model.ParseFromString(bytes));
  auto* output = model.mutable_graph()->add_output();
  output->set_name("mean");
  output->mutable_type()->mutable_tensor_type()->set_elem_type(onnx::TensorProto::FLOAT);
  onnx::ModelProto ours;
  ASSERT_TRUE(ours.ParseFromString(read(bytes, 8, "mean")));
  EXPECT_EQ(ours.SerializeAsString(), model.SerializeAsString());
  EXPECT_EQ(read(bytes, 8, "probabilities"), bytes) << "is an output already";
  EXPECT_EQ(read(bytes, 8, "nothing"), bytes) << "the labeler will say what there is";
}

TEST_F(OnnxFile, OfAnyBytesIsReadOrRefused) {
  const std::string good = test::smallOnnx(8, 4);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ (1 << i % 8));
    refused += test::caught([&] { read(bad, 8); }).code ? 1 : 0;
    onnx::ModelProto model;
    const bool isModel = model.ParseFromString(good.substr(0, i)) && model.has_graph();
    EXPECT_EQ(test::caught([&] { read(good.substr(0, i), 8); }).code.has_value(), !isModel) << i;
  }
  EXPECT_GT(refused, good.size() / 10);
}

}  // namespace
}  // namespace estancia
