// A library that says it is an ONNX Runtime of long ago.
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
