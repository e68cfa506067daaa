// External labeler: what programs, services, recordings and people share beside networks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "estancia/core/config.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/files/label_scores.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model_spec.hpp"

namespace estancia {

/// Reads the `keys` of model.toml that only this type has. Throws Error on unknown, wrong and missing keys.
void readBlackBox(ConfigFile& config, std::vector<ConfigFile::Key> keys);

/// Name and digest of what decides about the answers: the settings in model.toml except those named `without`
/// (a timeout must not invalidate the cache), the label file and these files, if they are some of the folder.
std::string blackBoxIdentity(const ModelSpec& spec, const ConfigFile& config,
                             const std::vector<std::filesystem::path>& files,
                             const std::vector<std::string>& without = {});

/// How the answers of programs and services become descriptors.
struct AnswerSettings {
  /// The number of labels of an answer that are used, the most probable first; 0 = all.
  std::size_t best = 0;
  io::WordFormat format;

  /// Its keys: best, scale, labels_at, label_key, confidence_key.
  std::vector<ConfigFile::Key> keys(ConfigFile& config);
};

/// The words of the model's label file, or those that it will discover.
io::WordBook wordBook(const ModelSpec& spec);

/// An answer's words as descriptor. Throws FrameError when there is no word.
LexicalDescriptor describe(io::WordBook& book, std::vector<LabelProbability> words, std::size_t best,
                           const std::string& source);

/// Type "http": a service that is sent an image by POST and answers with labels in JSON. Several requests are
/// in flight at a time (inferBatch()). What may pass (no connection, timeouts, HTTP 408, 429 and 5xx) is
/// tried again after growing waits; a refused image (400, 413, 415, 422) is a FrameError; all else is an
/// Error. Keys of model.toml: docs/how-to/labelers.md. Throws Error, which never holds the value of a secret.
std::unique_ptr<Labeler> openHttp(const ModelSpec& spec);

/// Type "process": a program that reads the path of a PNG file a line on stdin and writes one line of JSON
/// for each, in order, to stdout: {"image": PATH, "labels": {LABEL: confidence, …}}, or a list
/// [{"label": …, "confidence": …}, …], or {"image": PATH, "error": REASON}, which becomes a FrameError.
///
/// It is started with the first image. When it ends or answers too late it is started once more for the same
/// image; a second time in a row is an Error with its end and its last words on stderr. So is everything that
/// is no answer. Keys of model.toml: docs/how-to/labelers.md. Throws Error.
std::unique_ptr<Labeler> openProcess(const ModelSpec& spec);

}  // namespace estancia
