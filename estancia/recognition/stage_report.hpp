// What the stages of recognition tell of themselves.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace estancia {

/// What a stage took and left, for people.
struct StageReport {
  std::string stage;   ///< "keypoints"
  std::string detail;  ///< "uniform, 10 mm: 1,203 of 277,103 points"
  double seconds = 0;
};

/// Writes the reports of stages that follow one another: each took as long as it is since the last one.
class StageAccount {
 public:
  /// Into `stages`, if there are any.
  explicit StageAccount(std::vector<StageReport>* stages) : stages_(stages) {}

  void add(const std::string& stage, std::string detail) {
    const auto now = std::chrono::steady_clock::now();
    if (stages_ != nullptr)
      stages_->push_back({stage, std::move(detail), std::chrono::duration<double>(now - last_).count()});
    last_ = now;
  }

 private:
  std::vector<StageReport>* stages_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace estancia
