// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/false_alarms.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace estancia {
namespace {

constexpr double usual = 0.13;                     // evidence of wrong poses, at least
constexpr double unit = 0.15;                      // chance at which the scale is decay
constexpr double offset = 0.0135, decay = 0.0195;  // parameters of the tail, measured

}  // namespace

FalseAlarmModel::FalseAlarmModel(std::vector<double> wrong) {
  std::sort(wrong.begin(), wrong.end(), std::greater());
  wrong.resize(wrongPoses, usual);
  chance_ = std::max(usual, std::accumulate(wrong.begin(), wrong.end(), 0.0) / wrongPoses);
  scale_ = std::sqrt(chance_ / unit);
}

double FalseAlarmModel::rate(double evidence) const {
  return std::min(1.0, std::exp(-((evidence - chance_) / scale_ - offset) / decay));
}

double FalseAlarmModel::evidenceOf(double rate) const {
  return chance_ + scale_ * (offset - decay * std::log(rate));
}

double FalseAlarmModel::evidenceScale() const {
  return scale_ * decay;
}

}  // namespace estancia
