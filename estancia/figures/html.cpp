// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/html.hpp"

#include <fmt/format.h>

#include "estancia/core/base64.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"

namespace estancia::report {
namespace {

/// The media type by the file's first bytes; "" for anything else.
std::string_view imageType(std::string_view head) {
  if (head.starts_with("\xFF\xD8\xFF")) return "jpeg";
  if (head.starts_with("\x89PNG\r\n\x1A\n")) return "png";
  if (head.starts_with("GIF8")) return "gif";
  if (head.starts_with("RIFF") && head.substr(0, 12).ends_with("WEBP")) return "webp";
  return "";
}

}  // namespace

std::string escapeHtml(std::string_view text) {
  std::string out;
  for (const char c : cleanText(text)) {
    const char* entity = c == '&'    ? "&amp;"
                         : c == '<'  ? "&lt;"
                         : c == '>'  ? "&gt;"
                         : c == '"'  ? "&quot;"
                         : c == '\'' ? "&#39;"
                                     : nullptr;
    entity != nullptr ? out += entity : out += c;
  }
  return out;
}

void Markup::tag(std::string_view name, const Attributes& attributes) {
  out_ += fmt::format("<{}", name);
  for (const auto& [key, value] : attributes)
    out_ += fmt::format(" {}=\"{}\"", key, escapeHtml(value.text()));
}

Markup& Markup::open(std::string_view name, const Attributes& attributes) {
  tag(name, attributes);
  out_ += '>';
  open_.emplace_back(name);
  return *this;
}

Markup& Markup::close() {
  out_ += "</" + open_.back() + ">";
  open_.pop_back();
  return *this;
}

Markup& Markup::leaf(std::string_view name, const Attributes& attributes) {
  tag(name, attributes);
  out_ += "/>";
  return *this;
}

Markup& Markup::text(std::string_view text) {
  out_ += escapeHtml(text);
  return *this;
}

Markup& Markup::element(std::string_view name, const Attributes& attributes, std::string_view text) {
  return open(name, attributes).text(text).close();
}

Markup& Markup::add(const Markup& other) {
  out_ += other.out_;
  return *this;
}

std::string jsonForScript(std::string json) {
  std::string out;
  out.reserve(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (json[i] == '<')
      out += "\\u003c";
    else if (json.compare(i, 3, "\u2028") == 0 || json.compare(i, 3, "\u2029") == 0) {
      out += json[i + 2] == '\xA8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else
      out += json[i];
  }
  return out;
}

std::string imageUri(const std::vector<unsigned char>& bytes, const std::string& source) {
  const std::string_view file(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string_view type = imageType(file);
  if (type.empty())
    fail(ErrorCode::unsupportedFile, "{} is not a JPEG, PNG, GIF or WebP image; convert it first", source);
  return fmt::format("data:image/{};base64,{}", type, toBase64(file));
}

std::string htmlDocument(const std::string& title, const std::string& css, const Markup& body,
                         const std::string& data, const std::string& script) {
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  out +=
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; script-src 'sha256-" +
      toBase64(sha256Bytes(script)) + "'\">\n";
  out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += "<meta name=\"color-scheme\" content=\"light dark\">\n";
  out += "<title>" + escapeHtml(title) + "</title>\n<style>\n" + css + "</style>\n</head>\n<body>\n";
  out += body.str() + "\n";
  if (!data.empty())
    out += "<script type=\"application/json\" id=\"data\">" + jsonForScript(data) + "</script>\n";
  out += "<script>" + script + "</script>\n</body>\n</html>\n";
  return out;
}

}  // namespace estancia::report
