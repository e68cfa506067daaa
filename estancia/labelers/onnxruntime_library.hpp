// ONNX Runtime library: found and opened at run time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

struct OrtApi;

namespace estancia::onnxruntime {

/// ONNX Runtime, opened when first asked for: Estancia runs without it, and nothing that links Estancia
/// depends on it.
struct Library {
  const OrtApi* api = nullptr;
  /// "1.28.2".
  std::string version;
  /// Why there is none, one sentence with advice; "" when there is.
  std::string problem;
};

/// Looks for it in $ESTANCIA_ONNXRUNTIME (the library or its folder, and nowhere else when that is set),
/// where CMake found it, in $ESTANCIA_HOME/onnxruntime (script/bootstrap), and among the system's libraries.
const Library& library();

}  // namespace estancia::onnxruntime
