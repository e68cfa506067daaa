// Features: a sequence described frame by frame, the training data of classifiers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/descriptor.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

/// Frames with their descriptors. Invariant: a row of `values` a frame; the columns are those of the parts,
/// one part after the other.
struct Features {
  std::vector<DescriptorPart> parts;
  /// `room` is the class, "" where unknown.
  std::vector<Frame> frames;
  DescriptorMatrix values;

  /// "inception-v3+gist".
  std::string name() const;
};

struct DescribeOptions {
  /// Its threads also compute the other descriptors; the numbers do not depend on them.
  LabelerOptions labeler;
  /// Labels of earlier runs; null: none.
  LabelCache* cache = nullptr;
};

/// The frames that all of `descriptors` (names of descriptorTypes() or models; "A+B") can describe; the
/// reason for each skipped frame goes to `problems`. Throws Error when a name is unknown (unknownName) or
/// given twice (invalidOption), when no frame is left (insufficientData), and when the sequence lacks the
/// depth or intrinsics that a descriptor needs (invalidInput); Interrupted.
Features describeSequence(const Sequence& sequence, const std::string& descriptors,
                          const DescribeOptions& options = {}, Progress& progress = Progress::none(),
                          std::vector<std::string>* problems = nullptr);

/// One view as a single frame. Throws Error as describe().
Features featuresOf(const Descriptor& descriptor, const View& view);

/// The labels of a descriptor sequence (a label file, a map) as features; one part a model.
Features featuresOf(const DescriptorSequence& recording);

/// Keeps only the named parts, in that order. Throws Error (unknownName).
Features withParts(const Features& features, const std::vector<std::string>& names);

/// These rows, in that order. Throws Error (invalidInput) on a row that does not exist.
Features withRows(const Features& features, const std::vector<std::size_t>& rows);

/// The frames in these rooms; all without any. Throws Error (unknownName) that lists the known rooms.
Features withRooms(const Features& features, const std::vector<std::string>& rooms);

/// The rows of the frames that a sequence lists, by their names, with its rooms and poses.
Features withFramesOf(const Features& features, const Sequence& sequence);

/// The number of frames in each known room.
std::map<std::string, std::size_t> framesPerRoom(const Features& features);

struct NamedDescriptor {
  std::string name;
  std::unique_ptr<Descriptor> descriptor;
};

/// Loads the descriptors between the plus signs (an existing path is one name): descriptorTypes() or models.
/// Throws Error (unknownName, invalidOption) when a name is unknown, missing or given twice.
std::vector<NamedDescriptor> loadDescriptors(const std::string& names, const LabelerOptions& options = {});

/// Loads one combined descriptor for single views; describeSequence() is for sequences.
std::unique_ptr<Descriptor> loadDescriptor(const std::string& names, const LabelerOptions& options = {});

}  // namespace estancia
