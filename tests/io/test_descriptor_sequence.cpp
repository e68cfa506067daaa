// Recordings: read from what others write, written so that others can read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <limits>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {
namespace fs = std::filesystem;

using test::errorOf;
using test::readFile;
using test::writeFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> namesOf(const DescriptorSequence& recording) {
  std::vector<std::string> names;
  for (const Frame& frame : recording.frames) names.push_back(frame.name);
  return names;
}

/// A .npy file of version 1 with any header and any bytes behind it.
std::string npy(const std::string& header, const std::string& data) {
  std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size() & 0xFFU) +
                      static_cast<char>(header.size() >> 8U);
  return bytes + header + data;
}

std::string headerOf(const std::string& type, const std::string& shape,
                     const std::string& fortran = "False") {
  return "{'descr': " + type + ", 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

template <class Number>
std::string bytesOf(const std::vector<Number>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)};
}

class Recordings : public testing::Test {
 protected:
  DescriptorSequence read(const std::string& name, const std::string& bytes,
                          const DescriptorFileOptions& options = {}) {
    writeFile(scratch_ / name, bytes);
    return readDescriptors(scratch_ / name, options);
  }
  std::string refusal(const std::string& name, const std::string& bytes,
                      const DescriptorFileOptions& options = {}) {
    return errorOf([&] { read(name, bytes, options); });
  }
  fs::path file(const std::string& name, const std::string& bytes) {
    writeFile(scratch_ / name, bytes);
    return scratch_ / name;
  }
  test::ScratchFolder scratch_;
};

TEST_F(Recordings, WideCsv) {
  const auto recording = read("a.csv",
                              "\xEF\xBB\xBFimage, cup ,\"mug, beaker\",crane,crane\r\n1.png,0.5,0.25,0,1\n"
                              "\"2,b.png\",1e-5,1.00005,-0.00001,.5\n");
  EXPECT_THAT(recording.vocabulary.labels(), ElementsAre("cup", "mug, beaker", "crane", "crane"));
  EXPECT_THAT(namesOf(recording), ElementsAre("1.png", "2,b.png"));
  EXPECT_THAT(recording.descriptors.row(0), ElementsAre(0.5F, 0.25F, 0, 1));
  EXPECT_THAT(recording.descriptors.row(1), ElementsAre(1e-5F, 1, 0, 0.5F)) << "rounding is clamped";
  EXPECT_THAT(recording.model, testing::StartsWith("recorded "));
}

TEST_F(Recordings, LongCsv) {
  const std::string text = "image,label,probability\n1.png,cup,0.5\n2.png,mug,0.25\n1.png,spoon,0.75\n";
  const auto recording = read("a.csv", text);
  EXPECT_THAT(recording.vocabulary.labels(), ElementsAre("spoon", "cup", "mug"));
  EXPECT_THAT(namesOf(recording), ElementsAre("1.png", "2.png"));
  EXPECT_THAT(recording.descriptors.row(0), ElementsAre(0.75F, 0.5F, 0));
  const auto given = read("a.csv", text, {file("words.txt", "mug\nfork\ncup\n"), {}});
  EXPECT_THAT(given.descriptors.row(0), ElementsAre(0, 0, 0.5F));
  EXPECT_THAT(given.descriptors.row(1), ElementsAre(0.25F, 0, 0));
  EXPECT_NE(given.model, recording.model) << "other words";
}

TEST_F(Recordings, JsonLines) {
  const auto recording = read("a.jsonl", R"({"image": "1.png", "labels": {"cup": 0.25, "mug": 0.75}}

{"image": "2.png", "error": "too dark"}
{"image": "3.png", "labels": [{"label": "spoon", "confidence": 1}], "time": 3})");
  EXPECT_THAT(namesOf(recording), ElementsAre("1.png", "3.png"));
  EXPECT_THAT(recording.vocabulary.labels(), ElementsAre("mug", "cup", "spoon"));
  EXPECT_THAT(recording.descriptors.row(0), ElementsAre(0.75F, 0.25F, 0));
  EXPECT_THAT(recording.descriptors.row(1), ElementsAre(0, 0, 1));
}

TEST_F(Recordings, Npy) {
  file("a.labels.txt", "cup\nmug\n");
  const auto floats = read("a.npy", npy(headerOf("'<f4'", "(2, 2)"), bytesOf<float>({0, 0.25F, 0.5F, 1})));
  EXPECT_THAT(namesOf(floats), ElementsAre("frame 000000", "frame 000001"));
  EXPECT_THAT(floats.descriptors.row(1), ElementsAre(0.5F, 1));
  const auto doubles = read("a.npy", npy(headerOf("'<f8'", "(1, 2)"), bytesOf<double>({0.1, 1.00001})),
                            {{}, file("names.txt", "room/1.png\n")});
  EXPECT_THAT(doubles.descriptors.row(0), ElementsAre(0.1F, 1));
  EXPECT_THAT(namesOf(doubles), ElementsAre("room/1.png"));
  const auto listed = read("a.npy", npy(headerOf("'<f4'", "(1, 2)"), bytesOf<float>({0, 1})),
                           {{}, file("list.csv", "index,room,image,timestamp\n0,\"a, b\",x.png,1.5\n")});
  EXPECT_EQ(listed.frames[0].name, "x.png");
  EXPECT_EQ(listed.frames[0].room, "a, b");
  EXPECT_EQ(listed.frames[0].timestamp, 1.5);
  EXPECT_FALSE(listed.frames[0].pose);
}

TEST_F(Recordings, SurviveTheRoundTrip) {
  std::mt19937 random(1);
  DescriptorSequence recording{
      Vocabulary({"cup, mug", "\"quoted\"", "crane", "crane", "größe"}), "m", {}, DescriptorMatrix(5)};
  for (int i = 0; i < 500; ++i) {
    LexicalDescriptor row;
    for (int k = 0; k < 5; ++k)  // any float in [0, 1], tiny ones too
      row.push_back(
          std::bit_cast<float>(std::uniform_int_distribution<std::uint32_t>(0, 0x3F800000)(random)));
    recording.descriptors.append(row);
    Frame frame;
    frame.name = "room, \"1\"/" + std::to_string(i) + ".png";
    if (i % 2 == 0) frame.timestamp = 1e9 + 0.1 * i;
    if (i % 3 == 0) frame.pose = Pose::planar(0.1 * i, -2, 0.3);
    if (i % 5 == 0) frame.room = "kitchen, small";
    recording.frames.push_back(frame);
  }
  writeDescriptors(recording, scratch_ / "r.csv");
  writeDescriptors(recording, scratch_ / "r.npy");
  for (const std::string name : {"r.csv", "r.npy"}) {
    const auto back = readDescriptors(scratch_ / name);
    EXPECT_EQ(back.vocabulary, recording.vocabulary);
    EXPECT_EQ(namesOf(back), namesOf(recording));
    EXPECT_EQ(back.descriptors.values(), recording.descriptors.values()) << name;
  }
  const auto frames = readDescriptors(scratch_ / "r.npy").frames;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].timestamp, recording.frames[i].timestamp);
    EXPECT_EQ(frames[i].room, recording.frames[i].room);
    ASSERT_EQ(frames[i].pose.has_value(), recording.frames[i].pose.has_value());
    if (frames[i].pose) {
      EXPECT_EQ(frames[i].pose->x, recording.frames[i].pose->x);
      EXPECT_EQ(frames[i].pose->qw, recording.frames[i].pose->qw);
    }
  }
  const std::string bytes = readFile(scratch_ / "r.npy");
  EXPECT_EQ((bytes.size() - 500 * 5 * 4) % 64, 0U) << "NumPy aligns the numbers";
}

TEST_F(Recordings, RefuseBadCsv) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "a.csv:1: no header"},
      {"1.png,0.5\n", "a.csv:1: no header"},
      {"image,cup\n", "no images in it"},
      {"image,cup,\n1,0,0\n", "a.csv:1: column 3: a label without a name"},
      {"image,cup\n1.png,nan\n", "a.csv:2: nan for \"cup\" is no probability"},
      {"image,cup\n1.png,inf\n", "a.csv:2: inf for \"cup\""},
      {"image,cup\n1.png,87\n", "a.csv:2: 87 for \"cup\""},
      {"image,cup\n1.png,high\n", "a.csv:2: \"high\" is no number"},
      {"image,cup\n1.png,\n", "a.csv:2: \"\" is no number"},
      {"image,cup,mug\n1.png,0,1\n2.png,0\n", "a.csv:3: 2 cells where the header has 3"},
      {"image,cup\n1.png,0\n1.png,1\n", "a.csv:3: 1.png is in line 2 already"},
      {"image,cup\n,0\n", "a.csv:2: the image has no name"},
      {"image,cup\n\"1.png,0\n", "a.csv:2: a quote is never closed"},
      {"image,label,probability\n", "no images in it"},
      {"image,label,probability\n1.png,cup\n", "a.csv:2: 2 cells"},
      {"image,label,probability\n1.png,cup,NaN\n", "a.csv:2: nan for \"cup\""},
      {"image,label,probability\n1.png, ,1\n", "a.csv:2: a label without a name"}};
  for (const auto& [text, expected] : cases) EXPECT_THAT(refusal("a.csv", text), HasSubstr(expected)) << text;
  EXPECT_THAT(refusal("a.csv", "image,cup\n1.png,0\n", {file("words.txt", "mug\n"), {}}),
              HasSubstr("the vocabularies differ"));
  EXPECT_THAT(refusal("a.txt", "image,cup\n"), HasSubstr("known are .labels, .csv"));
  EXPECT_THAT(errorOf([&] { readDescriptors(scratch_ / "none.csv"); }),
              HasSubstr("no file that can be read"));
}

TEST_F(Recordings, RefuseBadJsonLines) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "no images in it"},
      {"{\"image\": \"1\", \"labels\": {}}\n{\"image\"", "a.jsonl:2: not JSON"},
      {"{\"labels\": {\"cup\": 1}}", "a.jsonl:1: the image has no name"},
      {"{\"image\": \"1\", \"labels\": {\"cup\": 2}}", "a.jsonl:1: 2 for \"cup\""},
      {"{\"image\": \"1\", \"labels\": {}}", "no words in it"},
      {"{\"image\": \"1\", \"labels\": {}}\n{\"image\": \"1\", \"labels\": {}}",
       "a.jsonl:2: 1 is in line 1 already"}};
  for (const auto& [text, expected] : cases)
    EXPECT_THAT(refusal("a.jsonl", text), HasSubstr(expected)) << text;
}

/// Few bytes must not make much memory.
TEST_F(Recordings, RefuseAHugeProductOfImagesAndWords) {
  std::string text = "image,label,probability\n";
  for (int i = 0; i < 30'000; ++i) text += std::to_string(i) + "," + std::to_string(i) + ",1\n";
  EXPECT_THAT(refusal("a.csv", text), HasSubstr("30000 images × 30000 words"));
}

TEST_F(Recordings, RefuseBadNpy) {
  file("a.labels.txt", "cup\nmug\n");
  const std::string two = bytesOf<float>({0, 1});
  const std::pair<std::string, std::string> cases[] = {
      {"", "not a .npy file"},
      {"PK\x03\x04 an archive", "not a .npy file"},
      {std::string("\x93NUMPY\x09\x00\x10\x00", 10) + std::string(40, ' '), "version 9"},
      {npy(headerOf("'<f4'", "(1, 2)"), two).substr(0, 30), "cut short"},
      {npy(headerOf("'<f4'", "(1, 2)"), two.substr(1)), "cut short or damaged"},
      {npy(headerOf("'<f4'", "(1, 2)"), two + "x"), "damaged"},
      {npy(headerOf("'<f4'", "(2, 2)"), two), "its shape is (2, 2), but it holds 8 bytes"},
      {npy(headerOf("'<f4'", "(9223372036854775808, 2)"), two), "damaged"},
      {npy(headerOf("'<f4'", "(2, 9223372036854775809)"), two), "damaged"},
      {npy(headerOf("'<f4'", "(99999999999999999999, 2)"), two), "no matrix"},
      {npy(headerOf("'<f4'", "(2,)"), two), "no matrix"},
      {npy(headerOf("'<f4'", "(1, 1, 2)"), two), "no matrix"},
      {npy(headerOf("'<f4'", "(0, 2)"), ""), "no matrix"},
      {npy(headerOf("'<f4'", "(-1, 2)"), two), "no matrix"},
      {npy(headerOf("'<f4'", "(1, 2)", "True"), two), "Fortran order"},
      {npy(headerOf("'>f4'", "(1, 2)"), two), "its numbers are '>f4'"},
      {npy(headerOf("'|O'", "(1, 2)"), two), "its numbers are '|O'"},
      {npy(headerOf("[('a', '<f4')]", "(1, 2)"), two), "write float32"},
      {npy("{}\n", two), "its numbers are"},
      {npy(headerOf("'<f4'", "(2, 1)"), two), "has 1 columns, but"},
      {npy(headerOf("'<f4'", "(1, 2)"), bytesOf<float>({0, std::numeric_limits<float>::quiet_NaN()})),
       "row 0: nan for \"mug\""},
      {npy(headerOf("'<f4'", "(1, 2)"), bytesOf<float>({0, 2})), "row 0: 2 for \"mug\""}};
  for (const auto& [bytes, expected] : cases) EXPECT_THAT(refusal("a.npy", bytes), HasSubstr(expected));
  const std::string sound = npy(headerOf("'<f4'", "(1, 2)"), two);
  EXPECT_THAT(refusal("a.npy", sound, {{}, file("n.csv", "1.png\n2.png\n")}),
              AllOf(HasSubstr("has 1 rows"), HasSubstr("names 2 images")));
  EXPECT_THAT(refusal("a.npy", sound, {{}, file("n.csv", "image,x\n1.png,7\n")}),
              HasSubstr("n.csv:2: a pose is"));
  EXPECT_THAT(refusal("a.npy", sound, {{}, file("n.csv", "image,timestamp\n1.png,soon\n")}),
              HasSubstr("n.csv:2: \"soon\" is no number"));
  EXPECT_THAT(refusal("b.npy", sound),
              AllOf(HasSubstr("its 2 columns have no names"), HasSubstr("b.labels.txt")));
  EXPECT_THAT(errorOf([&] { writeDescriptors(read("a.npy", sound), scratch_ / "r.bin"); }),
              HasSubstr("NAME.npy"));
}

}  // namespace
}  // namespace estancia
