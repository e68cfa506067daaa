// Ensemble: several models label each image; their vocabularies are joined.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model.hpp"

namespace estancia {

/// One of the models that work together.
struct EnsembleMember {
  std::unique_ptr<Labeler> labeler;
  /// > 0; how much it counts beside the others. Absent: √(its labels) where distances are fused, since more
  /// words carry more information; 1 where probabilities are.
  std::optional<float> weight = std::nullopt;
  /// > 0; p becomes p^(1/T) of the same sum: above 1 less sure of itself, below 1 more.
  float temperature = 1;
};

/// How answers become one descriptor.
enum class Fusion {
  /// The vocabularies stand side by side as parts (Vocabulary::layout()); a distance compares part by part
  /// and takes the weighted mean. The default: docs/measured/conjunction.md shows why.
  distances,
  /// Equal labels are merged, the others stand side by side; p(l) = Σ w_m p_m(l) / Σ w_m.
  probabilities
};

/// Joins the vocabularies of its members. Every member keeps its own entries in a label cache.
class Ensemble final : public Labeler {
 public:
  /// Throws Error without members, on weights or temperatures ≤ 0, on members that are ensembles or discover.
  Ensemble(std::string name, std::vector<EnsembleMember> members, Fusion fusion);

  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  std::string cacheKey() const override;
  bool needsImage() const override;
  std::vector<Labeler*> members() override;
  LexicalDescriptor combine(std::span<const LexicalDescriptor> answers) const override;
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override;
  /// Labels of members that are detectors; empty where equal labels are merged (Fusion::probabilities).
  std::vector<std::size_t> regionLabels() const override;
  std::vector<LexicalDescriptor> labelRegions(const cv::Mat& bgr,
                                              std::span<const cv::Rect2d> regions) override;
  LexicalDescriptor infer(const Prepared& prepared) override;

 private:
  std::vector<EnsembleMember> members_;
  Fusion fusion_;
  /// Position of each member's labels in the joined vocabulary.
  std::vector<std::vector<std::size_t>> places_;
  Vocabulary vocabulary_;
  std::string identity_;
};

/// Type "ensemble": `members` is a list of models, by name (or a folder beside model.toml), or of tables
/// { model, weight, temperature }; `fusion` is "distances" or "probabilities".
std::unique_ptr<Labeler> openEnsemble(const ModelSpec& spec, const LabelerOptions& options);

/// "A+B+…": these models with their own weights, distances fused.
std::unique_ptr<Labeler> openEnsemble(const std::string& names, const LabelerOptions& options);

/// The identities of the models behind the ensemble "A+B+…", in order; none unless all are as they were.
std::vector<std::string> identitiesOfMembers(const std::string& identity);

}  // namespace estancia
