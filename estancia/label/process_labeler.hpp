// Process labeler: a program of the user that labels images.
#pragma once

#include <memory>

#include "estancia/label/labeler.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Type "process": a program that reads the path of a PNG file a line on stdin and writes one line of JSON
/// for each, in order, to stdout: {"image": PATH, "labels": {LABEL: confidence, …}}, or a list
/// [{"label": …, "confidence": …}, …], or {"image": PATH, "error": "why this image has no words"}, which
/// becomes a FrameError.
///
/// It is started with the first image. When it ends or answers too late it is started once more for the same
/// image; a second time in a row is an Error with its end and its last words on stderr. So is everything that
/// is no answer. Keys of model.toml: docs/how-to/labelers.md. Throws Error.
std::unique_ptr<Labeler> openProcess(const ModelSpec& spec);

}  // namespace estancia
