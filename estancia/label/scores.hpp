// Network scores: the output of a network → probabilities, the same for every engine.
#pragma once

#include <span>

#include "estancia/core/descriptor.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

/// `output` holds one row of numbers, or with spec.reduce several (R×outputs, row by row; a detector's
/// anchors): the softmax or sigmoid that `spec` asks for makes them probabilities, each output takes its
/// highest of all rows, and those in spec.unused are dropped. Values after a sigmoid do not add up to 1.
/// Throws Error naming the model unless this gives `labels` probabilities.
LexicalDescriptor toProbabilities(std::span<const float> output, const ModelSpec& spec, std::size_t labels);

}  // namespace estancia
