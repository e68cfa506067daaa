// Markup that cannot be broken by its contents: everything that is written through it is escaped.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <initializer_list>
#include <utility>
#include <vector>

#include "estancia/figures/text.hpp"

namespace estancia::report {

/// Cleaned text (see cleanText) with & < > " ' escaped: safe between tags and in quoted attributes.
std::string escapeHtml(std::string_view text);

/// An attribute's value: text, or a number with at most two decimals.
class Value {
 public:
  Value(const char* text) : text_(text) {}                   // NOLINT(google-explicit-constructor)
  Value(const std::string& text) : text_(text) {}            // NOLINT(google-explicit-constructor)
  Value(std::floating_point auto v) : text_(number(v)) {}    // NOLINT(google-explicit-constructor)
  Value(std::integral auto v) : text_(std::to_string(v)) {}  // NOLINT(google-explicit-constructor)
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

using Attributes = std::vector<std::pair<std::string_view, Value>>;

/// Writes HTML and SVG elements. Names of elements and attributes are literals of ours; texts and values may
/// be anything. Invariant: every opened element is closed by close() before str() is asked for.
class Markup {
 public:
  Markup& open(std::string_view name, const Attributes& attributes = {});
  Markup& close();
  /// An element without contents.
  Markup& leaf(std::string_view name, const Attributes& attributes = {});
  Markup& text(std::string_view text);
  /// <name …>text</name>
  Markup& element(std::string_view name, const Attributes& attributes, std::string_view text);
  Markup& element(std::string_view name, std::string_view text) { return element(name, {}, text); }
  /// Whole elements of another Markup.
  Markup& add(const Markup& other);

  const std::string& str() const { return out_; }
  bool empty() const { return out_.empty(); }

 private:
  void tag(std::string_view name, const Attributes& attributes);

  std::string out_;
  std::vector<std::string> open_;
};

/// JSON text as it may stand in a <script> element: no "<", no line separators of JavaScript.
std::string jsonForScript(std::string json);

/// `data:image/…;base64,…` of a JPEG, PNG, GIF or WebP file. Throws Error naming `source` when the bytes are
/// none of these (SVG is refused: it may hold scripts and references).
std::string imageUri(const std::vector<unsigned char>& bytes, const std::string& source);

/// A whole document. A content security policy in it forbids every request and every script but `script`.
/// `data` is JSON for document.getElementById("data"), "" for none.
std::string htmlDocument(const std::string& title, const std::string& css, const Markup& body,
                         const std::string& data, const std::string& script);

}  // namespace estancia::report
