// TensorFlow.js reader: graph model (model.json and weight shards) → network graph.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "convert/tflite_graph.hpp"

namespace estancia::tfjs {

/// The part of a network that is wanted: from the node that is fed with the image to the node of the
/// scores.
struct Section {
  std::string input;          ///< name of a node; "" = the only placeholder
  std::string output;         ///< name of a node; "" = the only node that no other reads
  int width = 0, height = 0;  ///< size of the image [pixels]; 0 = as the placeholder declares
};

struct Network {
  std::vector<std::vector<float>> weights;  ///< what the graph's constants point to
  tflite::Graph graph;                      ///< input 1×height×width×3
};

/// Reads the operators between the two nodes; what lies before and behind (loops, resizing, boxes) need not
/// be known. All sizes follow from the image's. Nothing in the file is believed: sizes, shapes and names
/// are checked, weights lie in its folder. Throws Error naming the node that does not fit or the operator
/// that is not supported.
Network readGraph(const std::filesystem::path& modelJson, const Section& section);

}  // namespace estancia::tfjs
