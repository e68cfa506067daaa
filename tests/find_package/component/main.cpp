// Makes a topological map of descriptors, asks it for a word, and sees that no library came along that other
// rooms need; by the former names of a component and of a header, too:
//   component MAP
// SPDX-License-Identifier: Apache-2.0
#include <estancia/core/vocabulary.hpp>
#include <estancia/query/ask.hpp>
#include <estancia/topology/session.hpp>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

namespace {

/// Whether a library belongs to networks, pose graphs, classifiers or downloads.
bool isOfOtherRooms(const std::string& mapping) {
  for (const char* library :
       {"opencv_dnn", "opencv_ml", "libcholmod", "libsvm", "liblinear", "libcurl", "libarchive"})
    if (mapping.find(library) != std::string::npos) return true;
  return false;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  std::filesystem::remove(argv[1]);
  const estancia::Vocabulary words({"stove", "sofa"});
  auto session = estancia::MappingSession::create(argv[1], words, "component", {});
  for (int i = 0; i < 20; ++i) {
    estancia::Frame frame;
    frame.name = "frame " + std::to_string(i);
    session.add(frame,
                estancia::LexicalDescriptor(i < 10 ? std::vector{0.9F, 0.1F} : std::vector{0.1F, 0.9F}));
  }
  const auto answers = estancia::ask(session.map(), "sofa");
  std::cout << answers.places.size() << " places\n";
  std::ifstream mappings("/proc/self/maps");
  for (std::string line; std::getline(mappings, line);)
    if (isOfOtherRooms(line)) return std::cout << "not needed: " << line << '\n', 1;
  return answers.places.empty() ? 1 : 0;
} catch (const std::exception& error) {
  return std::cout << error.what() << '\n', 1;
}
