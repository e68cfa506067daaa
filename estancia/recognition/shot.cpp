// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "estancia/core/simd.hpp"
#include "estancia/recognition/descriptors.hpp"

namespace estancia {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr std::size_t minNeighbors = 5;
constexpr std::size_t together = 32;  // keypoints that a thread takes at once
const char* const stopped = "stopped while a surface was described";
constexpr int volumes = 32, cosines = 11, distances = 31;  // bins of each volume
constexpr int shapeLength = volumes * cosines, colorLength = shapeLength + volumes * distances;

/// Neighbors relative to the keypoint, by coordinate, for SIMD.
struct Offsets {
  std::vector<float> x, y, z, distance;
  std::size_t size = 0;

  void take(const Surface& surface, const cv::Point3f& p, std::span<const Neighbor> near) {
    if (x.size() < near.size())
      for (auto* list : {&x, &y, &z, &distance}) list->resize(near.size());
    size = 0;
    for (const Neighbor& n : near) {
      if (n.squared == 0) continue;
      const cv::Point3f d = surface.points()[n.index] - p;
      x[size] = d.x, y[size] = d.y, z[size] = d.z, distance[size] = std::sqrt(n.squared);
      ++size;
    }
  }
};

/// Σ weight d dᵀ: xx xy xz yy yz zz, and Σ weight.
ESTANCIA_MULTIVERSION void addUp(const Offsets& o, float radius, double* sums) {
  const float *x = o.x.data(), *y = o.y.data(), *z = o.z.data(), *distance = o.distance.data();
  const std::size_t n = o.size;
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0, all = 0;
#pragma omp simd reduction(+ : xx, xy, xz, yy, yz, zz, all)
  for (std::size_t i = 0; i < n; ++i) {
    const double weight = radius - distance[i], dx = x[i], dy = y[i], dz = z[i];
    const double wx = weight * dx, wy = weight * dy;
    xx += wx * dx, xy += wx * dy, xz += wx * dz, yy += wy * dy, yz += wy * dz, zz += weight * dz * dz;
    all += weight;
  }
  const double found[] = {xx, xy, xz, yy, yz, zz, all};
  std::copy_n(found, 7, sums);
}

ESTANCIA_MULTIVERSION std::size_t countAhead(const Offsets& o, double ax, double ay, double az) {
  const float *x = o.x.data(), *y = o.y.data(), *z = o.z.data();
  const std::size_t n = o.size;
  std::size_t ahead = 0;
#pragma omp simd reduction(+ : ahead)
  for (std::size_t i = 0; i < n; ++i) ahead += ax * x[i] + ay * y[i] + az * z[i] >= 0 ? 1 : 0;
  return ahead;
}

/// The sign of an axis: towards more of the neighbors; in a tie, towards more of the five with the middle
/// distances.
double signOf(const Eigen::Vector3d& axis, const Offsets& o) {
  const std::size_t twice = 2 * countAhead(o, axis[0], axis[1], axis[2]);
  if (twice != o.size) return twice < o.size ? -1 : 1;
  std::vector<std::size_t> order(o.size);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return o.distance[i] < o.distance[j]; });
  int votes = 0;
  for (std::size_t i = o.size / 2 - 2; i <= o.size / 2 + 2; ++i)
    if (axis.dot(Eigen::Vector3d(o.x[order[i]], o.y[order[i]], o.z[order[i]])) > 0) ++votes;
  return votes < 3 ? -1 : 1;
}

/// The sign of an axis: by the projections of the neighbors on it, weighted by proximity to the keypoint.
double weightedSignOf(const Eigen::Vector3d& axis, const Offsets& o, double radius) {
  double sum = 0;
  for (std::size_t i = 0; i < o.size; ++i) {
    const double along = axis[0] * o.x[i] + axis[1] * o.y[i] + axis[2] * o.z[i];
    const double weight = radius - static_cast<double>(o.distance[i]);
    sum += weight * weight * along * std::abs(along);
  }
  return sum < 0 ? -1 : 1;
}

cv::Matx33f localFrame(const Surface& surface, std::uint32_t keypoint, float radius, FrameSigns signs,
                       std::vector<Neighbor>& buffer, Offsets& offsets) {
  const cv::Point3f& p = surface.points()[keypoint];
  offsets.take(surface, p, surface.neighbors().within(p, radius, buffer));
  double s[7];
  addUp(offsets, radius, s);
  if (offsets.size < minNeighbors || !(s[6] > 0))
    return cv::Matx33f::all(std::numeric_limits<float>::quiet_NaN());
  Eigen::Matrix3d scatter;
  scatter << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(Eigen::Matrix3d(scatter / s[6]));
  Eigen::Vector3d x = axes.eigenvectors().col(2), z = axes.eigenvectors().col(0);
  if (signs == FrameSigns::normal) {
    const cv::Point3f& n = surface.normals()[keypoint];
    if (z.dot(Eigen::Vector3d(n.x, n.y, n.z)) < 0) z = -z;
    x *= weightedSignOf(x, offsets, radius);
  } else {
    x *= signOf(x, offsets);
    z *= signOf(z, offsets);
  }
  const Eigen::Vector3f fx = x.cast<float>(), fz = z.cast<float>(), fy = fz.cross(fx);
  return {fx[0], fx[1], fx[2], fy[0], fy[1], fy[2], fz[0], fz[1], fz[2]};
}

/// Neighbors in the local frame, by coordinate, for SIMD.
struct Votes {
  std::vector<float> x, y, z, distance, cosine, azimuth, inclination, color;
  void resize(std::size_t n) {
    for (auto* list : {&x, &y, &z, &distance, &cosine, &azimuth, &inclination, &color}) list->resize(n);
  }
};

/// asin(v)/v as a polynomial of v² ≤ ¼, error 1e-7 (Cephes asinf).
inline float asinSmall(float v) {
  const float s = v * v;
  return v +
         v * s *
             ((((4.2163199048e-2F * s + 2.4181311049e-2F) * s + 4.5470025998e-2F) * s + 7.4953002686e-2F) *
                  s +
              1.6666752422e-1F);
}

/// Angles of all votes: the azimuth around z, in [−π, π], and the inclination from z, in [0, π].
ESTANCIA_MULTIVERSION void angles(std::size_t n, const float* x, const float* y, const float* z,
                                  const float* distance, float* azimuth, float* inclination) {
  for (std::size_t i = 0; i < n; ++i) {
    const float c = std::clamp(z[i] / distance[i], -1.F, 1.F), a = std::abs(c);
    const bool steep = a > 0.5F;
    const float half = std::sqrt(std::max(0.5F * (1 - a), 0.F));
    const float s = asinSmall(steep ? half : a);
    const float flat = steep ? 2 * s : pi / 2 - s;  // acos(|c|)
    inclination[i] = c < 0 ? pi - flat : flat;

    const float ax = std::abs(x[i]), ay = std::abs(y[i]);
    const float low = std::min(ax, ay), high = std::max(ax, ay);
    float t = low / std::max(high, 1e-30F);  // tangent, in [0, 1]
    const bool far = t > 0.41421356F;        // tan(π/8)
    t = far ? (t - 1) / (t + 1) : t;
    const float t2 = t * t;
    float angle = (far ? pi / 4 : 0.F) + t +
                  t * t2 *
                      (((8.05374449538e-2F * t2 - 1.38776856032e-1F) * t2 + 1.99777106478e-1F) * t2 -
                       3.33329491539e-1F);
    angle = ay > ax ? pi / 2 - angle : angle;
    angle = x[i] < 0 ? pi - angle : angle;
    azimuth[i] = y[i] < 0 ? -angle : angle;
  }
}

/// One of the 32 volumes: 8 azimuths, each with 2 shells of 2 halves. Signs decide at the borders, as in PCL.
int volumeOf(float x, float y, float z, bool outer) {
  const int bit4 = (y > 0 || (y == 0 && x < 0)) ? 1 : 0;
  const int bit3 = (x > 0 || (x == 0 && y > 0)) ? 1 - bit4 : bit4;
  int volume = ((bit4 << 3) + (bit3 << 2)) << 1;
  if (x * y > 0 || x == 0)
    volume += std::abs(x) >= std::abs(y) ? 0 : 4;
  else
    volume += std::abs(x) > std::abs(y) ? 4 : 0;
  return volume + (z > 0 ? 1 : 0) + (outer ? 2 : 0);
}

/// How a neighbor shares its vote among its volume and the next shell, half and azimuth.
struct Shares {
  int volume = 0;
  std::array<int, 3> next{};             ///< volumes …
  std::array<float, 3> given{}, kept{};  ///< … what they get, and what remains
};

Shares sharesOf(const Votes& v, std::size_t i, float radius) {
  const float half = radius / 2, distance = v.distance[i];
  const bool outer = distance > half;
  Shares s;
  s.volume = volumeOf(v.x[i], v.y[i], v.z[i], outer);
  const auto share = [&s](std::size_t k, float off, bool isShared, int next) {
    s.kept[k] = 1 - std::abs(off);
    s.given[k] = isShared ? std::abs(off) : 0;
    s.next[k] = isShared ? next : s.volume;
  };
  const float shell = (distance - (outer ? 0.75F : 0.25F) * radius) / half;
  share(0, shell, outer ? shell <= 0 : shell >= 0, outer ? s.volume - 2 : s.volume + 2);

  const bool below = v.z[i] <= 0;
  const float tilt = (v.inclination[i] - (below ? 0.75F : 0.25F) * pi) / (pi / 2);
  share(1, tilt, below ? tilt <= 0 : tilt >= 0, below ? s.volume | 1 : s.volume & ~1);

  if (v.x[i] != 0 || v.y[i] != 0) {
    const int sector = s.volume >> 2;
    const float turn = std::clamp(
        (v.azimuth[i] - (-0.875F * pi + pi / 4 * static_cast<float>(sector))) / (pi / 4), -0.5F, 0.5F);
    share(2, turn, true, (s.volume + (turn > 0 ? 4 : 28)) % 32);
  }
  return s;
}

/// A neighbor adds 1 to the bin at `place` in 0 … bins − 1 of its volume, shared with the next bin and by
/// `shares`.
void vote(const Shares& shares, float place, int bins, float* histogram) {
  const int bin = static_cast<int>(place + 0.5F);
  const float off = place - static_cast<float>(bin);
  histogram[shares.volume * bins + (off > 0 ? (bin + 1) % (bins - 1) : (bin + bins - 2) % (bins - 1))] +=
      std::abs(off);
  float weight = 1 - std::abs(off);
  for (std::size_t k = 0; k < 3; ++k) {
    weight += shares.kept[k];
    histogram[shares.next[k] * bins + bin] += shares.given[k];
  }
  histogram[shares.volume * bins + bin] += weight;
}

/// Distance of colors in [0, 1], Tombari et al. 2011, with PCL's scale: L* counts twice as much as a* and b*.
float colorDistance(const cv::Vec3f& a, const cv::Vec3f& b) {
  const cv::Vec3f d = a - b;
  return std::min((std::abs(d[0]) / 100 + (std::abs(d[1]) + std::abs(d[2])) / 240) / 3, 1.F);
}

/// One row: the histograms of cosines, and with `colored` those of color distances from the keypoint.
void describeOne(const Surface& surface, std::uint32_t keypoint, const cv::Matx33f& frame, float radius,
                 bool colored, std::vector<Neighbor>& buffer, Votes& votes, float* shot) {
  const int length = colored ? colorLength : shapeLength;
  const cv::Point3f& p = surface.points()[keypoint];
  const std::span<const Neighbor> near = surface.neighbors().within(p, radius, buffer);
  if (near.size() < minNeighbors || !std::isfinite(frame(0, 0))) {
    std::fill_n(shot, length, std::numeric_limits<float>::quiet_NaN());
    return;
  }
  votes.resize(near.size());
  std::size_t n = 0;
  for (const Neighbor& neighbor : near) {
    if (neighbor.squared == 0) continue;
    const cv::Point3f d = surface.points()[neighbor.index] - p, &v = surface.normals()[neighbor.index];
    votes.x[n] = frame(0, 0) * d.x + frame(0, 1) * d.y + frame(0, 2) * d.z;
    votes.y[n] = frame(1, 0) * d.x + frame(1, 1) * d.y + frame(1, 2) * d.z;
    votes.z[n] = frame(2, 0) * d.x + frame(2, 1) * d.y + frame(2, 2) * d.z;
    votes.cosine[n] = frame(2, 0) * v.x + frame(2, 1) * v.y + frame(2, 2) * v.z;
    votes.distance[n] = std::sqrt(neighbor.squared);
    if (colored) votes.color[n] = colorDistance(surface.lab()[keypoint], surface.lab()[neighbor.index]);
    ++n;
  }
  angles(n, votes.x.data(), votes.y.data(), votes.z.data(), votes.distance.data(), votes.azimuth.data(),
         votes.inclination.data());
  std::fill_n(shot, length, 0.F);
  for (std::size_t i = 0; i < n; ++i) {
    const Shares shares = sharesOf(votes, i, radius);
    vote(shares, (1 + std::clamp(votes.cosine[i], -1.F, 1.F)) * (cosines - 1) / 2, cosines, shot);
    if (colored) vote(shares, votes.color[i] * (distances - 1), distances, shot + shapeLength);
  }
  double squares = 0;
  for (int i = 0; i < length; ++i) squares += static_cast<double>(shot[i]) * shot[i];
  const auto norm = static_cast<float>(std::sqrt(squares));
  for (int i = 0; i < length; ++i) shot[i] /= norm;
}

}  // namespace

std::vector<cv::Matx33f> localFrames(const Surface& surface, std::span<const std::uint32_t> keypoints,
                                     double radius, int threads, FrameSigns signs) {
  std::vector<cv::Matx33f> frames(keypoints.size());
  inChunks(keypoints.size(), together, threads, stopped, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbor> buffer;
    Offsets offsets;
    for (std::size_t i = begin; i < end; ++i)
      frames[i] = localFrame(surface, keypoints[i], static_cast<float>(radius), signs, buffer, offsets);
  });
  return frames;
}

void describeShot(const Surface& surface, std::span<const std::uint32_t> keypoints,
                  std::span<const cv::Matx33f> frames, double radius, bool colored, int threads,
                  std::vector<float>& values) {
  const auto length = static_cast<std::size_t>(colored ? colorLength : shapeLength);
  values.resize(keypoints.size() * length);
  inChunks(keypoints.size(), together, threads, stopped, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbor> buffer;
    Votes votes;
    for (std::size_t i = begin; i < end; ++i)
      describeOne(surface, keypoints[i], frames[i], static_cast<float>(radius), colored, buffer, votes,
                  values.data() + i * length);
  });
}

}  // namespace estancia
