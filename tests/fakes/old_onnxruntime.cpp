// A library that claims to be an ONNX Runtime of long ago.
// SPDX-License-Identifier: Apache-2.0
namespace {

struct ApiBase {
  const void* (*getApi)(unsigned);
  const char* (*getVersion)();
};
const ApiBase base{[](unsigned) -> const void* { return nullptr; }, [] { return "1.10.0"; }};

}  // namespace

extern "C" const ApiBase* OrtGetApiBase() {
  return &base;
}
