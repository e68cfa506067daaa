// What a network puts out → probabilities, the same for every engine.
#pragma once

#include <span>

#include "estancia/core/descriptor.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Applies the softmax that `spec` asks for. Throws Error naming the model unless this gives `labels`
/// probabilities.
LexicalDescriptor toProbabilities(std::span<const float> output, const ModelSpec& spec, std::size_t labels);

}  // namespace estancia
