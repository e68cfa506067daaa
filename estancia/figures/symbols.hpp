// The symbol of a class (a room, a zone): alone for legends, with a number as a badge.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "estancia/figures/color.hpp"
#include "estancia/figures/html.hpp"

namespace estancia::report {

/// Symbols that a page's script repaints are drawn with this radius, and scaled.
constexpr double unitRadius = 10;

/// Width for a text inside a symbol, in radii.
double textRoom(std::size_t shape);

/// How far a symbol reaches from its middle, in radii.
double reachOf(std::size_t shape);

/// An <svg> of the symbol, hidden from screen readers: the name stands beside it.
Markup symbol(const ClassStyle& style);

/// An <svg> of the symbol with a short text inside.
Markup badge(const ClassStyle& style, const std::string& text);

}  // namespace estancia::report
