// TensorFlow Lite reader: file → network graph, every index and size checked.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "convert/tflite_graph.hpp"

namespace estancia::tflite {

/// Reads the first subgraph of the file. `source` names the file in messages.
/// Throws Error on anything that is not a whole TFLite file of one image input and one output, on wrong
/// indices or sizes, and on an operator that is not in `Kind` (which is named).
Graph readGraph(std::span<const std::uint8_t> file, const std::string& source);

}  // namespace estancia::tflite
