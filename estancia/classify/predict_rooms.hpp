// Rooms for the images of a run: words that are known already are taken, the rest is described.
#pragma once

#include <string>
#include <vector>

#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/sequence.hpp"

namespace estancia {

/// What images must be described by for this classifier, as describeSequence() takes it: "inception-v3+gist".
std::string descriptorOf(const RoomClassifier& classifier);

/// "svm-rbf on inception-v3+gist"
std::string nameOf(const RoomClassifier& classifier);

/// Throws Error, saying what to install or to give, unless images can be described by that here.
void requireDescribable(const RoomClassifier& classifier);

/// The same for the images of `sequence`, which needs depth where the classifier does.
void requireDescribable(const RoomClassifier& classifier, const Sequence& sequence);

/// Throws Error, saying what is missing, unless words of these parts are all that the classifier needs.
void requireParts(const RoomClassifier& classifier, const std::vector<DescriptorPart>& words);

/// A row a frame of `frames`, found in the features by name; all 0 for frames that these do not hold. Throws
/// Error as RoomClassifier::predict() does.
RoomPredictions predictRooms(const RoomClassifier& classifier, const Features& features,
                             const std::vector<Frame>& frames, int threads = 0);

/// The frames of `words` in what the classifier needs. Of the parts that it was taught those that the words
/// are made of are taken from there; only the others are described, from `sequence`, which may be nullptr
/// where there are none. Frames that cannot be described, or that the sequence lacks, are left out, and
/// `problems` told. Throws Error saying what is missing, and as describeSequence() does; Interrupted.
Features featuresFor(const RoomClassifier& classifier, const DescriptorSequence& words,
                     const Sequence* sequence, const DescribeOptions& options, Progress& progress,
                     std::vector<std::string>* problems = nullptr);

}  // namespace estancia
