// World list: the areas of a map, each with the objects in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/figures/html.hpp"
#include "estancia/report/world_view.hpp"

namespace estancia::report {

/// A <section> "areas": areas as articles with the id area-<id>, objects as links with the id object-<id>,
/// the most probable first; what is in no area comes last. Empty for a map without areas and objects.
Markup worldList(const WorldView& view);

}  // namespace estancia::report
