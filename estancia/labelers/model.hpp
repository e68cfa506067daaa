// Models: find by name, load, install and check the networks and other labelers of this machine.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model_spec.hpp"

namespace estancia {

class OptionGroup;

/// The model that is used if the user names none.
inline const std::string defaultModel = "inception-v3";

/// Where models live, one folder each: $ESTANCIA_HOME/models, else ~/.local/share/estancia/models.
std::filesystem::path modelHome();

/// The folder of a model: `model` is a name in modelHome(), or a folder with a model.toml anywhere.
/// Throws Error listing the known names.
std::filesystem::path getModelFolder(const std::string& model);

/// How to run a model.
struct LabelerOptions {
  /// One of engines(); "" takes the fastest that can open the network.
  std::string engine;
  /// Threads of a network; 0 = one per free core.
  int threads = 0;
  /// Open a network at its first frame only, as its labels may all be in the cache.
  bool onDemand = false;
  /// Arithmetic of networks. In 8 bits they need ONNX Runtime and give other numbers: another identity(),
  /// `NAME int8-DIGEST`.
  Precision precision = Precision::float32;
  /// Networks see JPEG files at 1/2, 1/4 or 1/8 of their size, but no smaller than their input: quicker to
  /// decode, with slightly other numbers and another identity(), `NAME reduced-DIGEST`.
  bool reducedImages = false;
};

OptionGroup declare(LabelerOptions& options);

/// Loads a model by name or folder; "A+B+…" loads several as an ensemble. Throws Error when it is unknown or
/// wrong in any way.
std::unique_ptr<Labeler> loadModel(const std::string& model = defaultModel,
                                   const LabelerOptions& options = {});
std::unique_ptr<Labeler> loadModel(const ModelSpec& spec, const LabelerOptions& options = {});

/// Adds a type of labeler: its name is the `type` in model.toml.
using LabelerFactory = std::function<std::unique_ptr<Labeler>(const ModelSpec&, const LabelerOptions&)>;
void registerLabelerType(const std::string& type, LabelerFactory open);
std::vector<std::string> labelerTypes();

/// The engines at hand that run networks, best first.
std::vector<std::string> engines();
/// Engines that can open this network, best first; empty for models that are no networks.
std::vector<std::string> enginesFor(const ModelSpec& spec);

/// A folder of the model home: its spec, or why that cannot be read.
struct InstalledModel {
  std::filesystem::path folder;
  std::optional<ModelSpec> spec;
  std::string problem;
};

/// Everything in modelHome(), by name; empty when there is no home yet.
std::vector<InstalledModel> installedModels();

/// Result of checkModel() for a model that works.
struct ModelCheck {
  ModelSpec spec;
  std::string identity;
  std::size_t labels = 0;
  /// Files whose SHA-256 was compared with model.toml.
  std::size_t digests = 0;
  /// Median of inference alone, on this machine now.
  double millisecondsPerImage = 0;
  /// The first label of the test image (noise), to see that it is no constant.
  std::string best;
  double bestProbability = 0;
  std::vector<std::string> labelNames = {};
};

/// Opens the model, labels a gray and a noisy image and takes the time. Throws Error saying what is wrong
/// with it.
ModelCheck checkModel(const std::string& model, const LabelerOptions& options = {});

/// Copies the model in `folder` (the files that its model.toml names; all of it when it is no network) into
/// modelHome() under its name, after checking it. Throws Error when it does not work, or when the name is
/// taken and `replace` is false. Nothing stays behind then.
ModelCheck addModel(const std::filesystem::path& folder, bool replace = false);

}  // namespace estancia
