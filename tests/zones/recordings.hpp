// Small recordings for the tests of zones.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "support/synthetic.hpp"

namespace estancia::test {

/// One frame a row, called "0", "1", …; the labels are "word 0", "word 1", ….
inline DescriptorSequence recordingOf(const std::vector<std::vector<float>>& rows) {
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < rows.at(0).size(); ++i) labels.push_back("word " + std::to_string(i));
  DescriptorSequence recording{Vocabulary(labels), "test", {}, DescriptorMatrix(labels.size())};
  for (const auto& row : rows) {
    Frame frame;
    frame.name = std::to_string(recording.frames.size());
    recording.frames.push_back(frame);
    recording.descriptors.append(row);
  }
  return recording;
}

/// A drive through rooms 0, 1, 2 … of 20 words, `stay` images in each visit; their rooms are known.
inline DescriptorSequence driveThrough(const std::vector<std::size_t>& rooms, std::size_t stay,
                                       unsigned seed = 7) {
  SyntheticPlaces places(6, 20, 0.4, seed);
  DescriptorSequence recording = recordingOf(places.drive(rooms, stay));
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    recording.frames[i].room = "room " + std::to_string(rooms[i / stay]);
  return recording;
}

}  // namespace estancia::test
