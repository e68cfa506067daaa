// The images of things as a sequence, for whatever labels sequences.
#pragma once

#include <memory>

#include "estancia/cloud/crop_object.hpp"
#include "estancia/io/object_views.hpp"
#include "estancia/io/sequence.hpp"

namespace estancia {

/// A frame a view, called as it is, whose image is cropObject() its image, or renderObject() its cloud where
/// it has none. `views` must outlive it.
std::unique_ptr<Sequence> patchesOf(const ObjectViews& views, const CropOptions& options = {});

}  // namespace estancia
