// Object crops: the images of object views as a sequence, for labelers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "estancia/cloud/crop_object.hpp"
#include "estancia/readers/object_views.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

/// One frame a view, of the same name: cropObject() of its image, or renderObject() of its cloud without one.
/// `views` must outlive it.
std::unique_ptr<Sequence> cropsOf(const ObjectViews& views, const CropOptions& options = {});

}  // namespace estancia
