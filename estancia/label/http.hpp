// HTTP labeler: a web service that labels images.
#pragma once

#include <memory>

#include "estancia/label/labeler.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Type "http": a service that is sent an image by POST and answers with labels in JSON. Several requests are
/// in flight at a time (inferBatch()). What may pass (no connection, timeouts, HTTP 408, 429 and 5xx) is
/// tried again after growing waits; a refused image (400, 413, 415, 422) is a FrameError; all else is an
/// Error. Keys of model.toml: docs/how-to/labelers.md. Throws Error, which never holds the value of a secret.
std::unique_ptr<Labeler> openHttp(const ModelSpec& spec);

}  // namespace estancia
