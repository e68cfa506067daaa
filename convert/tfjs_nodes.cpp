// SPDX-License-Identifier: Apache-2.0
#include "convert/tfjs_nodes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>

#include "convert/tfjs_json.hpp"

namespace estancia::tfjs {
namespace {

using Json = nlohmann::json;

std::string fromBase64(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : text.substr(0, text.find('='))) {
    const auto digit = digits.find(c);
    if (digit == std::string::npos)
      throw Error(ErrorCode::malformedFile, fmt::format("has {} where base64 is needed", inQuotes(text)));
    bits = (bits << 6 | static_cast<unsigned>(digit)) & 0xFFFF;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xFF);
  }
  return bytes;
}

/// Texts are stored in base64 or as lists of bytes.
std::string textOf(const Json& value) {
  if (value.is_string()) return fromBase64(value.get<std::string>());
  const auto bytes = value.get<std::vector<unsigned char>>();
  return {bytes.begin(), bytes.end()};
}

/// 64-bit integers are stored as texts.
std::int64_t integerOf(const Json& value) {
  if (!value.is_string()) return value.get<std::int64_t>();
  const auto text = value.get<std::string>();
  std::int64_t number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc{} || end != text.data() + text.size())
    throw Error(ErrorCode::malformedFile, fmt::format("has {} where an integer is needed", inQuotes(text)));
  return number;
}

}  // namespace

std::string Node::where() const {
  return fmt::format("{} (node {})", op.substr(0, 100), inQuotes(name));
}

void Node::fail(const std::string& what, ErrorCode code) const {
  throw Error(code, fmt::format("{} in {}", what, where()));
}

const Json* Node::find(const char* attribute) const {
  if (attributes == nullptr) return nullptr;
  const auto found = attributes->find(attribute);
  return found == attributes->end() ? nullptr : &*found;
}

std::int64_t Node::integer(const char* attribute, std::int64_t otherwise) const {
  const Json* stored = find(attribute);
  return stored == nullptr || !stored->contains("i") ? otherwise : integerOf(stored->at("i"));
}

double Node::real(const char* attribute, double otherwise) const {
  const Json* stored = find(attribute);
  return stored == nullptr || !stored->contains("f") ? otherwise : stored->at("f").get<double>();
}

bool Node::flag(const char* attribute) const {
  const Json* stored = find(attribute);
  return stored != nullptr && stored->contains("b") && stored->at("b").get<bool>();
}

std::string Node::text(const char* attribute, const std::string& otherwise) const {
  const Json* stored = find(attribute);
  return stored == nullptr ? otherwise : textOf(stored->at("s"));
}

std::vector<std::int64_t> Node::integers(const char* attribute) const {
  std::vector<std::int64_t> list;
  if (const Json* stored = find(attribute); stored != nullptr && stored->at("list").contains("i"))
    for (const auto& value : stored->at("list").at("i")) list.push_back(integerOf(value));
  return list;
}

std::vector<std::string> Node::texts(const char* attribute) const {
  std::vector<std::string> list;
  if (const Json* stored = find(attribute); stored != nullptr && stored->at("list").contains("s"))
    for (const auto& value : stored->at("list").at("s")) list.push_back(textOf(value));
  return list;
}

std::vector<std::int64_t> Node::shape() const {
  std::vector<std::int64_t> sizes;
  const Json* stored = find("shape");
  if (stored == nullptr || !stored->contains("shape") || !stored->at("shape").contains("dim")) return sizes;
  for (const auto& dimension : stored->at("shape").at("dim"))
    sizes.push_back(integerOf(dimension.at("size")));
  return sizes;
}

std::pair<int, int> Node::perSide(const char* attribute, std::optional<int> otherwise) const {
  const auto list = integers(attribute);
  if (list.empty() && otherwise) return {*otherwise, *otherwise};
  if (list.size() != 4 || list[0] != 1 || list[3] != 1 ||
      std::any_of(list.begin(), list.end(), [](auto v) { return v < 1 || v > 1024; }))
    fail(fmt::format("has {} of [{}]", attribute, fmt::join(list, ", ")));
  return {static_cast<int>(list[1]), static_cast<int>(list[2])};
}

bool Node::samePadding() const {
  const std::string padding = text("padding", "");
  if (padding != "SAME" && padding != "VALID")
    fail("has a padding other than SAME and VALID", ErrorCode::unsupportedFile);
  return padding == "SAME";
}

void Node::requireChannelsLast() const {
  if (text("data_format", "NHWC") != "NHWC")
    fail("has an order of dimensions other than NHWC", ErrorCode::unsupportedFile);
}

void Node::requireInputs(std::size_t count) const {
  if (inputs.size() != count) fail(fmt::format("has {} inputs where {} are needed", inputs.size(), count));
}

Nodes::Nodes(const Json& list) {
  for (const auto& stored : list) {
    Node node{stored.at("name").get<std::string>(), stored.at("op").get<std::string>(), {}, nullptr};
    if (stored.contains("input"))
      for (const auto& input : stored.at("input")) {
        auto name = input.get<std::string>();
        if (name.starts_with('^')) continue;  // a control edge: orders execution, carries no data
        if (name.ends_with(":0")) name.resize(name.size() - 2);
        node.inputs.push_back(std::move(name));
      }
    if (stored.contains("attr")) node.attributes = &stored.at("attr");
    const std::string name = node.name;
    if (!nodes_.emplace(name, std::move(node)).second)
      throw Error(ErrorCode::malformedFile, fmt::format("has two nodes of the name {}", inQuotes(name)));
  }
}

const Node& Nodes::at(const std::string& name) const {
  const auto found = nodes_.find(name);
  if (found == nodes_.end())
    throw Error(ErrorCode::malformedFile, fmt::format("has no node {}", inQuotes(name)));
  return found->second;
}

std::string Nodes::onlyPlaceholder() const {
  std::vector<std::string> names;
  for (const auto& [name, node] : nodes_)
    if (node.op == "Placeholder") names.push_back(name);
  if (names.size() != 1)
    throw Error(ErrorCode::invalidInput,
                fmt::format("has {} placeholders; name the node of the image as `input_node`", names.size()));
  return names[0];
}

std::string Nodes::onlyEnd() const {
  std::set<std::string> ends;
  for (const auto& [name, node] : nodes_) ends.insert(name);
  for (const auto& [name, node] : nodes_)
    for (const auto& input : node.inputs) ends.erase(input.substr(0, input.rfind(':')));
  if (ends.size() == 1) return *ends.begin();
  std::vector<std::string> some;
  for (const auto& end : ends)
    if (some.size() < 10) some.push_back(inQuotes(end));
  throw Error(ErrorCode::invalidInput, fmt::format("has {} outputs ({}); name one of its nodes as `output`",
                                                   ends.size(), fmt::join(some, ", ")));
}

std::vector<const Node*> Nodes::inOrder(const std::string& input, const std::string& output,
                                        const std::function<void(const Node&)>& visit) const {
  enum class State { entered, done };
  std::map<const Node*, State> states{{&at(input), State::done}};
  std::vector<const Node*> order, open{&at(output)};  // no recursion: a hostile chain may be long
  while (!open.empty()) {
    const Node* node = open.back();
    const auto [state, isNew] = states.try_emplace(node, State::entered);
    if (!isNew) {
      open.pop_back();
      if (std::exchange(state->second, State::done) == State::entered) order.push_back(node);
      continue;
    }
    visit(*node);
    for (const auto& name : node->inputs) {
      const Node* read = &at(name);
      const auto seen = states.find(read);
      if (seen == states.end())
        open.push_back(read);
      else if (seen->second == State::entered)
        node->fail(fmt::format("has a loop through {}", inQuotes(name)));
    }
  }
  return order;
}

}  // namespace estancia::tfjs
