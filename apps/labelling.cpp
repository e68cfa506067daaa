#include "labelling.hpp"

namespace estancia::apps {

void ModelArguments::addTo(CLI::App& command, const std::string& what) {
  command.add_option("--model", model, what + ": a name of `models list`, or a folder")
      ->capture_default_str();
  addOptionsTo(command);
}

void ModelArguments::addOptionsTo(CLI::App& command) {
  const auto labelling = "Labelling";
  command.add_option("--engine", options.engine, "What runs the network; default: the fastest at hand")
      ->check(CLI::IsMember({"onnxruntime", "opencv"}))
      ->group(labelling);
  command.add_option("--threads", options.threads, "Threads of the network; default: one a free core")
      ->check(CLI::Range(1, 1024))
      ->group(labelling);
}

std::unique_ptr<Labeler> ModelArguments::open() const {
  return loadModel(model, options);
}

}  // namespace estancia::apps
