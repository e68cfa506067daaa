// Stage reports: what each stage of recognition got, kept and cost.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/pose_hypothesis.hpp"
#include "estancia/recognition/recognizer.hpp"

namespace estancia {

/// Writes the reports of consecutive stages: each took the time since the one before.
class StageLog {
 public:
  /// Into `stages`, if given.
  explicit StageLog(std::vector<StageReport>* stages) : stages_(stages) {}

  void add(const std::string& stage, std::string detail);
  /// Stages that were run before, with this before their names.
  void append(const std::vector<StageReport>& stages, const std::string& prefix = "");

  // ---- the stages of find()
  void matched(const RecognitionOptions& options, std::size_t modelKeypoints, std::size_t sceneKeypoints,
               std::size_t matches);
  void grouped(const RecognitionOptions& options, double consistency,
               const std::vector<PoseHypothesis>& poses);
  void refined(const RecognitionOptions& options, const std::vector<PoseHypothesis>& poses);
  /// `refined` are the poses before verification, best first; `instances` what is accepted of them.
  void verified(const RecognitionOptions& options, const std::vector<PoseHypothesis>& refined,
                const Instances& instances);

 private:
  std::vector<StageReport>* stages_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace estancia
