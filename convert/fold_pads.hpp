// Pad folding: paddings with zeros become part of the convolutions that read them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <onnx/onnx_pb.h>

namespace estancia::convert {

/// Removes each Pad node (operator set 11 to 17) that writes zeros around images which only convolutions
/// read, and adds its widths to theirs. ONNX Runtime does so, too, but cannot where one side is in 8 bits.
void foldPads(onnx::GraphProto& graph);

}  // namespace estancia::convert
