// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/model_file.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

/// The content: behind a right digest.
FUZZ_TARGET(classify, room_classifier) {
  const std::filesystem::path file = folder() / "input.rooms";
  writeModelFile(file, roomClassifierKind, bytes);
  readRoomClassifier(file);
}

FUZZ_TARGET(classify, room_classifier_file) {
  readRoomClassifier(inputFile("input.rooms", bytes));
}

}  // namespace estancia::fuzz
