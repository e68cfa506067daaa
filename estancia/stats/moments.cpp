// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/moments.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "estancia/core/bytes.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

/// mean += share · (x − mean), with the part that float32 cannot hold kept in carry.
ESTANCIA_MULTIVERSION
void moveMean(float* mean, float* carry, const float* x, float share, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const float step = share * ((x[i] - mean[i]) - carry[i]) + carry[i];
    const float moved = mean[i] + step;
    carry[i] = step - (moved - mean[i]);
    mean[i] = moved;
  }
}

/// Updates the variance, too: v += share · ((x − mean before)(x − mean after) − v).
ESTANCIA_MULTIVERSION
void moveMeanAndVariance(float* mean, float* carry, float* variance, const float* x, float share,
                         std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const float before = (x[i] - mean[i]) - carry[i];
    const float step = share * before + carry[i];
    const float moved = mean[i] + step;
    carry[i] = step - (moved - mean[i]);
    mean[i] = moved;
    const float after = (x[i] - mean[i]) - carry[i];
    variance[i] = std::max(0.0F, variance[i] + share * (before * after - variance[i]));
  }
}

}  // namespace

Moments::Moments(std::size_t labels, bool spread)
    : mean_(labels, 0.0F), carry_(labels, 0.0F), variance_(spread ? labels : 0, 0.0F) {}

void Moments::add(std::span<const float> x, double weight) {
  weight_ += weight;
  if (weight_ <= 0) throw Error(ErrorCode::invalidState, "more weight is removed from a node than it has");
  const auto share = static_cast<float>(weight / weight_);
  if (variance_.empty())
    moveMean(mean_.data(), carry_.data(), x.data(), share, mean_.size());
  else
    moveMeanAndVariance(mean_.data(), carry_.data(), variance_.data(), x.data(), share, mean_.size());
}

void Moments::merge(const Moments& other) {
  if (other.weight_ <= 0) return;
  const double total = weight_ + other.weight_;
  const double share = other.weight_ / total;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double own = static_cast<double>(mean_[i]) + carry_[i];
    const double theirs = static_cast<double>(other.mean_[i]) + other.carry_[i];
    const double merged = own + share * (theirs - own);
    if (!variance_.empty())
      variance_[i] = static_cast<float>((1 - share) * variance_[i] + share * other.variance_[i] +
                                        share * (1 - share) * (theirs - own) * (theirs - own));
    mean_[i] = static_cast<float>(merged);
    carry_[i] = static_cast<float>(merged - mean_[i]);
  }
  weight_ = total;
}

void Moments::remove(const Moments& other) {
  const double left = weight_ - other.weight_;
  const bool isEmpty = left <= 1e-9 * weight_;
  const double share = isEmpty ? 0 : other.weight_ / left;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double own = static_cast<double>(mean_[i]) + carry_[i];
    const double theirs = static_cast<double>(other.mean_[i]) + other.carry_[i];
    const double without = isEmpty ? 0 : own + share * (own - theirs);
    mean_[i] = static_cast<float>(without);
    carry_[i] = static_cast<float>(without - mean_[i]);
  }
  weight_ = isEmpty ? 0 : left;
}

std::size_t Moments::byteCount(std::size_t labels, bool spread) {
  return sizeof(double) + labels * sizeof(float) * (spread ? 3 : 2);
}

std::string Moments::toBytes() const {
  ByteWriter writer;
  writer.number(weight_);
  for (const auto* values : {&mean_, &carry_, &variance_})
    writer.raw({reinterpret_cast<const char*>(values->data()), values->size() * sizeof(float)});
  return writer.bytes();
}

Moments Moments::fromBytes(std::string_view bytes, std::size_t labels, bool spread) {
  if (bytes.size() != byteCount(labels, spread))
    throw Error(ErrorCode::corruptFile,
                "a node state of the map has the wrong size; the file is damaged, map again");
  Moments moments(labels, spread);
  const char* in = bytes.data();
  const auto get = [&in](void* to, std::size_t count) {
    if (count > 0) std::memcpy(to, in, count);
    in += count;
  };
  get(&moments.weight_, sizeof moments.weight_);
  for (auto* values : {&moments.mean_, &moments.carry_, &moments.variance_}) {
    get(values->data(), values->size() * sizeof(float));
    if (!std::all_of(values->begin(), values->end(), [](float v) { return std::isfinite(v); }))
      throw Error(ErrorCode::corruptFile,
                  "a node state of the map is not finite; the file is damaged, map again");
  }
  if (!(moments.weight_ >= 0) || !std::isfinite(moments.weight_))
    throw Error(ErrorCode::corruptFile,
                "a node of the map has an invalid weight; the file is damaged, map again");
  return moments;
}

}  // namespace estancia
