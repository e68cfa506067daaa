// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>
#include <set>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/home.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/labelers/black_box.hpp"
#include "estancia/labelers/engines.hpp"
#include "estancia/labelers/ensemble.hpp"
#include "estancia/labelers/model_files.hpp"
#include "estancia/labelers/network_labeler.hpp"
#include "estancia/labelers/recorded_labeler.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// A network opened at its first frame: a run whose labels are all cached opens none. Knows its words and
/// identity at once; what is wrong with the network itself shows at the first frame.
class OnDemandNetwork final : public NetworkLabeler {
 public:
  using Open = std::function<std::unique_ptr<Labeler>()>;
  OnDemandNetwork(const ModelSpec& spec, std::string engine, Open open)
      : NetworkLabeler(spec, std::move(engine)), open_(std::move(open)) {}

  LexicalDescriptor infer(const Prepared& prepared) override { return network().infer(prepared); }
  std::vector<LexicalDescriptor> labelRegions(const cv::Mat& bgr,
                                              std::span<const cv::Rect2d> regions) override {
    return network().labelRegions(bgr, regions);
  }
  std::vector<LabelResult> inferBatch(std::span<const Prepared> batch) override {
    return network().inferBatch(batch);
  }
  std::size_t batchSize() const override { return network().batchSize(); }

 private:
  Labeler& network() const {
    if (!network_) network_ = open_();
    if (network_->identity() != identity())
      fail(ErrorCode::corruptFile, "model {} was changed while it was used; start again", spec().name);
    return *network_;
  }

  Open open_;
  mutable std::unique_ptr<Labeler> network_;
};

/// Throws Error when `engine` cannot compute in 8 bits.
void requireInt8(const std::string& engine, const LabelerOptions& options) {
  if (engine == "onnxruntime") return;
  if (options.engine.empty() && onnxruntime::library().api == nullptr)
    throw Error(ErrorCode::missingDependency, onnxruntime::library().problem);
  fail(ErrorCode::invalidOption,
       "networks of 8 bits need the engine onnxruntime, not {}; leave out --precision int8{}", engine,
       options.engine.empty() ? "" : " or --engine");
}

/// A network with the engine that its type or the user names, or the best one that can open it.
std::unique_ptr<Labeler> openNetwork(const ModelSpec& given, const LabelerOptions& options) {
  ModelSpec spec = inPrecision(given, options.precision);
  spec.reducedImages = options.reducedImages;
  const std::string engine = !options.engine.empty()  ? options.engine
                             : spec.type == "network" ? enginesFor(spec).front()
                                                      : spec.type;
  if (spec.type != "network" && spec.type != engine)
    fail(ErrorCode::invalidOption, "model {} is made for the engine {}, not {}; leave out --engine",
         spec.name, spec.type, engine);
  const bool onnxruntime = engine == "onnxruntime";
  if (!onnxruntime && engine != "opencv")
    fail(ErrorCode::unknownName, "unknown engine \"{}\"; at hand are {}", engine, fmt::join(engines(), ", "));
  if (options.precision == Precision::int8) requireInt8(engine, options);
  const auto open = [=, threads = options.threads] {
    return onnxruntime ? openWithOnnxruntime(spec, threads) : openWithOpencv(spec, threads);
  };
  if (!options.onDemand) return open();
  return std::make_unique<OnDemandNetwork>(spec, onnxruntime ? onnxruntimeVersion() : opencvVersion(), open);
}

/// Labelers that are no networks have no engine to choose.
LabelerFactory blackBox(std::unique_ptr<Labeler> (*open)(const ModelSpec&)) {
  return [open](const ModelSpec& spec, const LabelerOptions&) { return open(spec); };
}

struct Registry {
  std::mutex mutex;
  std::map<std::string, LabelerFactory> types{
      {"network", &openNetwork},
      {"opencv", &openNetwork},
      {"onnxruntime", &openNetwork},
      {"ensemble",
       [](const ModelSpec& spec, const LabelerOptions& options) { return openEnsemble(spec, options); }},
      {"process", blackBox(openProcess)},
      {"http", blackBox(openHttp)},
      {"recorded", blackBox(openRecorded)},
      {"human", blackBox(openHuman)}};
};

Registry& registry() {
  static Registry instance;
  return instance;
}

ModelCheck check(const ModelSpec& given, const LabelerOptions& options) {
  const auto labeler = loadModel(given, options);  // labels a gray image, too
  const ModelSpec spec = isNetworkType(given.type) ? inPrecision(given, options.precision) : given;
  if (!labeler->needsImage())
    return {spec, labeler->identity(),           labeler->vocabulary().size(), spec.sha256.size(), 0, "",
            0,    labeler->vocabulary().labels()};
  const auto& pre = spec.preprocessing;
  cv::Mat noise(pre.height, pre.width, CV_8UC3);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  const Prepared prepared = labeler->prepare(noise);

  LexicalDescriptor words;
  std::vector<double> times(isNetworkType(spec.type) ? 7 : 1);  // services may charge for each
  for (double& time : times) {
    const auto start = std::chrono::steady_clock::now();
    words = labeler->infer(prepared);
    time = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }
  const auto median = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), median, times.end());

  const auto best = std::max_element(words.begin(), words.end());
  ModelCheck result{spec,  labeler->identity(),           words.size(), spec.sha256.size(), *median, "",
                    *best, labeler->vocabulary().labels()};
  result.best = labeler->vocabulary()[static_cast<std::size_t>(best - words.begin())];
  return result;
}

/// A folder that disappears again unless it is kept.
class PartialFolder {
 public:
  explicit PartialFolder(fs::path path) : path_(std::move(path)) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~PartialFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void copyModel(const ModelSpec& spec, const fs::path& target) {
  // The files that a program needs beside it are known to its author only.
  if (!isNetworkType(spec.type)) return fs::copy(spec.folder, target, fs::copy_options::recursive);
  std::set<fs::path> files{"model.toml"};
  for (const auto& file : networkFiles(spec)) files.insert(file);
  if (!spec.int8.empty()) files.insert(spec.int8);
  if (!spec.labels.empty()) files.insert(spec.labels);
  for (const auto& [file, digest] : spec.sha256) files.insert(file);
  for (const auto& file : files) {
    fs::create_directories((target / file).parent_path());
    fs::copy_file(modelFile(spec, file), target / file);
  }
}

/// Puts `fresh` in the place of `target` with renames only.
void swapIn(const fs::path& fresh, const fs::path& target) {
  if (!fs::exists(target)) return fs::rename(fresh, target);
  const PartialFolder old(fresh.string() + ".old");
  fs::rename(target, old.path() / "model");
  fs::rename(fresh, target);
}

}  // namespace

fs::path modelHome() {
  const std::string home = environment("ESTANCIA_HOME");
  if (!home.empty()) return fs::path(home) / "models";
  return userHome() / ".local/share/estancia/models";
}

fs::path getModelFolder(const std::string& model) {
  const bool isPath = model.find('/') != std::string::npos || model == "." || model == "..";
  if (!isPath && !model.empty() && fs::is_directory(modelHome() / model)) return modelHome() / model;
  if (fs::is_regular_file(fs::path(model) / "model.toml")) return model;
  if (isPath) fail(ErrorCode::fileNotFound, "{} is no model: it holds no model.toml", model);
  std::vector<std::string> known;
  for (const auto& installed : installedModels()) known.push_back(installed.folder.filename().string());
  if (known.empty())
    fail(ErrorCode::unknownName,
         "no model \"{}\", nor any other, in {}; run estancia-fetch (script/bootstrap in the source), or "
         "`estancia models get NAME`, or `estancia models add FOLDER`",
         model, modelHome().string());
  fail(ErrorCode::unknownName, "unknown model \"{}\"; known are {}", model, fmt::join(known, ", "));
}

std::unique_ptr<Labeler> loadModel(const std::string& model, const LabelerOptions& options) {
  if (splitAtPlus(model).size() > 1) return openEnsemble(model, options);
  return loadModel(readModelSpec(getModelFolder(model)), options);
}

OptionGroup declare(LabelerOptions& options) {
  OptionGroup group("labeler", "How a model is run.");
  group.add("engine", &options.engine, "What runs the network: onnxruntime or opencv.")
      .automatic("the fastest that can open it")
      .why("OpenCV opens more formats; ONNX Runtime is two to four times as fast.");
  group.add("threads", &options.threads, "Threads of the network; 0 = one per free core.")
      .range(0, 1024)
      .why("Leaves cores to other work.");
  group.add("on-demand", &options.onDemand, "Open the network at its first frame only.")
      .why("A run whose labels are all cached opens none.");
  group
      .add("precision", options.precision,
           {{{"float32", "real numbers"}, Precision::float32},
            {{"int8", "8 bits: 1.8 times as fast with large networks, slightly other labels"},
             Precision::int8}},
           "How exactly the network computes.")
      .why(
          "Large networks label 1.8 times the images a second; maps and labels of the other precision do not "
          "fit.");
  group
      .add("reduced-images", &options.reducedImages,
           "Decode JPEG files at 1/2, 1/4 or 1/8 of their size, but no smaller than the network's input.")
      .why("Reading takes longer than a small network; maps and labels of whole images do not fit.");
  return group;
}

std::unique_ptr<Labeler> loadModel(const ModelSpec& spec, const LabelerOptions& options) {
  validate(options);
  LabelerFactory open;
  {
    const std::lock_guard lock(registry().mutex);
    if (const auto found = registry().types.find(spec.type); found != registry().types.end())
      open = found->second;
  }
  if (!open)
    fail(ErrorCode::unknownName, "model {}: unknown type \"{}\"; known are {}", spec.name, spec.type,
         fmt::join(labelerTypes(), ", "));
  return open(spec, options);
}

void registerLabelerType(const std::string& type, LabelerFactory open) {
  const std::lock_guard lock(registry().mutex);
  registry().types[type] = std::move(open);
}

std::vector<std::string> labelerTypes() {
  const std::lock_guard lock(registry().mutex);
  std::vector<std::string> names;
  for (const auto& [name, open] : registry().types) names.push_back(name);
  return names;
}

std::vector<std::string> engines() {
  if (onnxruntime::library().api == nullptr) return {"opencv"};
  return {"onnxruntime", "opencv"};
}

std::vector<std::string> enginesFor(const ModelSpec& spec) {
  auto those = engines();
  std::erase_if(those, [&spec](const std::string& engine) {
    return !isNetworkType(spec.type) || (spec.type != "network" && spec.type != engine) ||
           (engine == "onnxruntime" && !isOnnx(spec));
  });
  return those;
}

std::vector<InstalledModel> installedModels() {
  std::vector<InstalledModel> models;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(modelHome(), none)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') || !entry.is_directory()) continue;
    InstalledModel model{entry.path(), std::nullopt, ""};
    try {
      model.spec = readModelSpec(entry.path());
    } catch (const Error& e) {
      model.problem = e.what();
    }
    models.push_back(std::move(model));
  }
  std::sort(models.begin(), models.end(), [](auto& a, auto& b) { return a.folder < b.folder; });
  return models;
}

ModelCheck checkModel(const std::string& model, const LabelerOptions& options) {
  return check(readModelSpec(getModelFolder(model)), options);
}

ModelCheck addModel(const fs::path& folder, bool replace) {
  if (fs::is_regular_file(folder))
    fail(ErrorCode::invalidInput,
         "{} is a file; put it into a folder with a label file and a model.toml that says how to use it",
         folder.string());
  const ModelSpec spec = readModelSpec(folder);
  const fs::path target = modelHome() / spec.name;
  if (fs::exists(target) && !replace)
    fail(ErrorCode::fileExists,
         "there is a model {} already in {}; use --overwrite, or another name in model.toml", spec.name,
         modelHome().string());
  try {
    const PartialFolder fresh(modelHome() / fmt::format(".{}.{}", spec.name, getpid()));
    copyModel(spec, fresh.path());
    ModelCheck result = check(readModelSpec(fresh.path()), {});
    swapIn(fresh.path(), target);
    result.spec.folder = target;
    return result;
  } catch (const fs::filesystem_error& e) {
    fail(ErrorCode::fileUnwritable, "cannot write the model into {}: {}", modelHome().string(),
         e.code().message());
  }
}

}  // namespace estancia
