// Zero-shot rooms: rooms of images by what their labels have to do with the rooms' names, without example.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

struct WordGraph;

/// Evidence of a vocabulary's labels for rooms, for runs of images: WordNet is asked once.
class RoomsByNames {
 public:
  /// Same parameters as predictRoomsByNames().
  RoomsByNames(const WordGraph& graph, const Vocabulary& vocabulary,
               const std::vector<std::string>& rooms = {});
  /// Throws Error (mismatch) when `images` has other labels.
  RoomPredictions predict(const DescriptorMatrix& images) const;

 private:
  bool areListed_;
  std::vector<std::string> rooms_;
  DescriptorLayout layout_;
  std::vector<std::vector<float>> weights_;
};

/// Rooms of the images of one run, by the labels of one model or several.
///
/// An image's evidence for a room is that of its labels (roomLabelWeights()), weighted by the square roots of
/// their probabilities less half of the run's mean (Hellinger). Models count the same. `rooms` that the user
/// has listed are taken to occur: in runs of 20 images or more each room's evidence is standardized over the
/// run. Without a list, commonRooms() are tried. How often each room occurs is estimated by expectation
/// maximization (Saerens, Latinne & Decaestecker 2002: Adjusting the outputs of a classifier to new a priori
/// probabilities), and is the result's `prior`. Without a list the result has the evidence of the eight
/// labels with most evidence of each image, by which areSureRooms() judges. Rows of zeros have no prediction.
///
/// Throws Error (mismatch) on other labels, (insufficientData) on one room, and as roomLabelWeights().
RoomPredictions predictRoomsByNames(const WordGraph& graph, const Vocabulary& vocabulary,
                                    const DescriptorMatrix& images,
                                    const std::vector<std::string>& rooms = {});

/// How much the rooms' names count beside a classifier that was trained on so many images a room, in [0, 1]:
/// less with each, nothing from 40 on. Chosen on the training half of NYU Depth V2 (docs/measured/words.md).
double shareOfNames(double imagesPerRoom);

/// Predictions of a trained classifier with the rooms' names as their prior: `trained` times the `share`-th
/// power of `byNames`, normalized. Images without a trained prediction stay without one. Throws Error
/// (mismatch) unless both are of the same images and rooms.
RoomPredictions withNames(RoomPredictions trained, const RoomPredictions& byNames, double share);

}  // namespace estancia
