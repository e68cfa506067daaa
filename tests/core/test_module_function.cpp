// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/module_function.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/core.hpp>

#include "estancia/core/image_codecs.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

TEST(ModuleFunction, IsFoundOrItsModuleIsMissing) {
  EXPECT_THAT([] { getModuleFunction("libnowhere.so", "../lib", "f", "stars cannot be counted"); },
              FailsWith(ErrorCode::missingDependency));
  EXPECT_THAT([] { getModuleFunction("libm.so.6", "../lib", "nonesuch", "nothing works"); },
              FailsWith(ErrorCode::missingDependency));
  EXPECT_NE(getModuleFunction("libm.so.6", "../lib", "cos", "nothing works"), nullptr);
  EXPECT_THAT([] { getModuleFunction("libnowhere.so", "../lib", "f", "nothing works", "stars-dev"); },
              FailsWith(ErrorCode::missingDependency));
}

TEST(ImageCodecs, MayBeOpenedBySeveralThreadsAtOnce) {
  const cv::Mat gray(8, 8, CV_8UC3, cv::Scalar::all(90));
  std::array<double, 4> worst{};
  test::inThreads(4, [&](int t) {
    const auto jpeg = imageCodecs().encodeJpeg(gray, 95);
    worst[static_cast<std::size_t>(t)] =
        cv::norm(imageCodecs().decode(jpeg, DecodedAs::color), gray, cv::NORM_INF);
  });
  for (const double difference : worst) EXPECT_LE(difference, 1);
  EXPECT_TRUE(imageCodecs().decode(std::array<unsigned char, 3>{1, 2, 3}, DecodedAs::stored).empty());
}

}  // namespace
}  // namespace estancia
