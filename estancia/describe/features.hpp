// A whole sequence described: what classifiers learn from.
#pragma once

#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/descriptor.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/label/label_cache.hpp"
#include "estancia/label/model.hpp"

namespace estancia {

/// Frames with the numbers that describe them. Invariant: a row of `values` a frame; the columns are those of
/// the parts, one part after the other.
struct Features {
  std::vector<DescriptorPart> parts;
  std::vector<Frame> frames;  ///< `room` is the class, "" where unknown
  DescriptorMatrix values;

  /// "inception-v3+gist".
  std::string name() const;
};

struct DescribeOptions {
  LabelerOptions labeler;       ///< its threads also describe; the numbers do not depend on them
  LabelCache* cache = nullptr;  ///< of words that were paid for before
};

/// The frames that all of `descriptors` (names of descriptorTypes() or models; each may be "A+B") can
/// describe; why others are left out is told in `problems`, one sentence a frame. Throws Error when a name is
/// unknown (listing the known ones) or given twice, when no frame is left, and when the sequence has no depth
/// but a descriptor needs it; Interrupted when the user asks to stop.
Features describeSequence(const Sequence& sequence, const std::string& descriptors,
                          const DescribeOptions& options, Progress& progress,
                          std::vector<std::string>* problems = nullptr);

/// What is seen now, as one frame of the view's name. Throws Error as describe() does.
Features featuresOf(const Descriptor& descriptor, const View& view);

/// The words of a recording (a label file, a map) as features; one part a model of it.
Features featuresOf(const DescriptorSequence& recording);

/// The same frames in the parts that are named, in that order. Throws Error listing the parts there are.
Features withParts(const Features& features, const std::vector<std::string>& names);

/// The rows that are named, in that order.
Features withRows(const Features& features, const std::vector<std::size_t>& rows);

}  // namespace estancia
