// convert_network: the converter alone, for script/bootstrap, before there is a library and its command.
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string_view>

#include "convert/to_onnx.hpp"

int main(int count, char** arguments) try {
  if (count == 5 && std::string_view(arguments[1]) == "--quantize") {
    estancia::convert::writeQuantized(arguments[2], arguments[3], arguments[4]);
    return 0;
  }
  if (count != 3 && count != 6) {
    std::cerr << "usage: convert_network NETWORK OUTPUT.onnx [INPUT_NODE OUTPUT_NODE SIDE]\n"
                 "       convert_network --quantize NETWORK.onnx RANGES OUTPUT.onnx\n";
    return 2;
  }
  estancia::convert::NetworkSource source{.file = arguments[1]};
  if (count == 6) {
    source.inputNode = arguments[3];
    source.outputNode = arguments[4];
    source.width = source.height = std::atoi(arguments[5]);
  }
  estancia::convert::writeOnnx(source, arguments[2], true);
  return 0;
} catch (const std::exception& e) {
  std::cerr << "convert_network: " << e.what() << '\n';
  return 2;
}
