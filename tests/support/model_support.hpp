// Models for the tests: folders with a model.toml, small ONNX networks, the networks beside the project.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "estancia/labelers/model_spec.hpp"
#include "support/support.hpp"

namespace onnx {
class GraphProto;
}

namespace estancia::test {

/// Whether there is ONNX Runtime; with CI set its absence is a failure.
bool findOnnxruntime();

/// `count` lines "word 0" ….
std::string labelLines(std::size_t count);

/// A model.toml for `file`, `labels.txt` and a square `input`, with further lines.
std::string modelToml(const std::string& file, int input, const std::string& more = "");

/// A network 1×3×side×side → `outputs` probabilities: softmax of a linear map of the mean color.
/// `change` may alter the graph before it is written.
std::string smallOnnx(int side, int outputs, const std::function<void(onnx::GraphProto&)>& change = {});

/// Writes smallOnnx(8, 4) with its labels and model.toml into `folder`.
void writeSmallModel(const std::filesystem::path& folder, const std::string& more = "");

/// A spec for a network of the shared test models, whose files are copied (or converted) into `scratch`.
ModelSpec testModel(const std::filesystem::path& models, const std::string& file, const std::string& labels,
                    const Preprocessing& preprocessing, const ScratchFolder& scratch);

/// Preprocessing of the MobileNets: center 87.5 %, RGB, x / 127.5 − 1.
Preprocessing mobilenetInput(int side);

/// Every n-th photograph of nyuv2_half, at most `count`.
std::vector<cv::Mat> photographs(const std::filesystem::path& nyuv2, std::size_t count);

/// Positions of the `count` largest values, largest first.
std::vector<std::size_t> best(const std::vector<float>& values, std::size_t count);

}  // namespace estancia::test
