// Image descriptor: turns a view (image, depth) into numbers; the common interface of labels, GIST, PHOG and
// ESF.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Meaning of a part's numbers, which decides how they are compared.
enum class PartKind {
  /// Labels: a distribution, or independent probabilities (a detector).
  probabilities,
  /// Shares of a whole, ≥ 0 (PHOG, ESF).
  histogram,
  /// Filter responses, ≥ 0 (GIST), or any other measure.
  energies,
};

/// Numbers of one source. Combined descriptors ("inception-v3+gist") have several parts.
struct DescriptorPart {
  /// "gist", "inception-v3"
  std::string name;
  PartKind kind = PartKind::energies;
  /// One a number: the labels of a model; "gist 0", "gist 1" …
  std::vector<std::string> columns;
  /// Identifies all that the numbers depend on: parameters, seed, files of a network.
  std::string identity;

  std::size_t size() const { return columns.size(); }
  bool operator==(const DescriptorPart&) const = default;
};

/// The input of a descriptor.
struct View {
  /// BGR, 8 bits; empty unless needsImage().
  cv::Mat image = {};
  /// Meters, CV_32F, 0 for holes; empty unless needsDepth().
  cv::Mat depth = {};
  /// Camera of the depth image.
  std::optional<CameraIntrinsics> camera = {};
  /// Name of the frame in its sequence.
  std::string frame = {};
};

/// PHOG, GIST, ESF, or the labels of a labeler. Safe to use from several threads.
class Descriptor {
 public:
  virtual ~Descriptor() = default;

  /// The parts, in the order of the numbers: one, or several of a combined descriptor. A labeler that
  /// discovers labels has those known so far.
  virtual std::vector<DescriptorPart> parts() const = 0;
  virtual bool needsImage() const { return true; }
  virtual bool needsDepth() const { return false; }

  /// Returns as many numbers as parts() have. Throws Error (invalidInput, insufficientData) when this view
  /// cannot be described (no depth, too few points …).
  virtual std::vector<float> describe(const View& view) const = 0;
};

/// The descriptors without labels: phog, gist, esf.
Choices descriptorTypes();

/// One of descriptorTypes(), with its default parameters; null for other names, which are models
/// (loadDescriptors() loads both).
std::unique_ptr<Descriptor> findDescriptor(const std::string& name);

}  // namespace estancia
