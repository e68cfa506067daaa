// A frame → numbers: the one interface of everything that describes, words included.
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// What the numbers of a part mean; it decides how they are compared.
enum class PartKind {
  probabilities,  ///< words: a distribution, or independent probabilities (a detector)
  histogram,      ///< shares of a whole, ≥ 0 (PHOG, ESF)
  energies,       ///< answers of filters, ≥ 0 (GIST), or any other measure
};

/// Numbers of one source. Descriptors that are put together ("inception-v3+gist") have several.
struct DescriptorPart {
  std::string name;  ///< "gist", "inception-v3"
  PartKind kind = PartKind::energies;
  std::vector<std::string> columns;  ///< one a number: the labels of a model; "gist 0", "gist 1" …
  std::string identity;  ///< of all that the numbers depend on: parameters, seed, files of a network

  std::size_t size() const { return columns.size(); }
  bool operator==(const DescriptorPart&) const = default;
};

/// What there is to describe of one moment.
struct View {
  cv::Mat image;  ///< BGR, 8 bits; empty unless needsImage()
  cv::Mat depth;  ///< meters, CV_32F, 0 where there is none; empty unless needsDepth()
  std::optional<CameraIntrinsics> camera;  ///< of depth
  std::string frame;                       ///< its name in the sequence
};

/// Anything that turns a view into numbers: PHOG, GIST, ESF, or a labeler's words.
class Descriptor {
 public:
  virtual ~Descriptor() = default;

  /// What the numbers are, in their order: one part, or several of what is put together. A labeler that
  /// discovers words has those known so far.
  virtual std::vector<DescriptorPart> parts() const = 0;
  virtual bool needsImage() const { return true; }
  virtual bool needsDepth() const { return false; }

  /// As many numbers as parts() have. Safe to call from several threads. Throws Error when this view cannot
  /// be described (no depth, too few points …): the next may be.
  virtual std::vector<float> describe(const View& view) const = 0;
};

/// The descriptors that are no words, each with one line of explanation: phog, gist, esf.
std::vector<std::pair<std::string, std::string>> descriptorTypes();

/// One of descriptorTypes(), with its standard parameters; null for other names, which are models
/// (load_descriptor.hpp opens both).
std::unique_ptr<Descriptor> findDescriptor(const std::string& name);

}  // namespace estancia
