#include "export/recorded.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Operations that one expression holds, of values that are used once.
constexpr int most_in_a_row = 12;

bool is(const Recorded& x, double value) { return x.node < 0 && x.value == value; }

std::string literal(double value) {
  const std::string out = exact(value);
  return out.find_first_of(".en") == std::string::npos ? out + ".0" : out;
}

Recorded function(std::string_view name, double (*f)(double), const Recorded& x) {
  return x.node < 0 ? Recorded(f(x.value)) : Recording::made(std::string(name) + "(#)", {x});
}

Recorded ordered(std::string_view form, const Recorded& a, const Recorded& b) {
  return a.node < b.node ? Recording::made(form, {b, a}) : Recording::made(form, {a, b});
}

}  // namespace

Recorded operator+(const Recorded& a, const Recorded& b) {
  if (a.node < 0 && b.node < 0) {
    return a.value + b.value;
  }
  return is(a, 0.0) ? b : is(b, 0.0) ? a : ordered("# + #", a, b);
}

Recorded operator-(const Recorded& a, const Recorded& b) {
  if (a.node < 0 && b.node < 0) {
    return a.value - b.value;
  }
  return is(b, 0.0) ? a : is(a, 0.0) ? -b : Recording::made("# - #", {a, b});
}

Recorded operator*(const Recorded& a, const Recorded& b) {
  if (a.node < 0 && b.node < 0) {
    return a.value * b.value;
  }
  if (is(a, 0.0) || is(b, 0.0)) {
    return 0.0;
  }
  return is(a, 1.0) ? b : is(b, 1.0) ? a : is(a, -1.0) ? -b : is(b, -1.0) ? -a : ordered("# * #", a, b);
}

Recorded operator/(const Recorded& a, const Recorded& b) {
  if (a.node < 0 && b.node < 0) {
    return a.value / b.value;
  }
  return is(a, 0.0) ? Recorded(0.0) : is(b, 1.0) ? a : Recording::made("# / #", {a, b});
}

Recorded operator-(const Recorded& a) { return a.node < 0 ? Recorded(-a.value) : Recording::made("-#", {a}); }

RecordedChoice operator>(const Recorded& a, const Recorded& b) {
  return {a.node < 0 && b.node < 0 ? Recorded(a.value > b.value ? 1.0 : 0.0)
                                   : Recording::made("# > #", {a, b})};
}

Recorded select(const RecordedChoice& choice, const Recorded& a, const Recorded& b) {
  const bool same = a.node == b.node && (a.node >= 0 || a.value == b.value);
  if (choice.condition.node < 0 || same) {
    return is(choice.condition, 0.0) ? b : a;
  }
  return Recording::made("# ? # : #", {choice.condition, a, b});
}

Recorded sin(const Recorded& x) { return function("sin", std::sin, x); }
Recorded cos(const Recorded& x) { return function("cos", std::cos, x); }
Recorded tanh(const Recorded& x) { return function("tanh", std::tanh, x); }
Recorded exp(const Recorded& x) { return function("exp", std::exp, x); }
Recorded sqrt(const Recorded& x) { return function("sqrt", std::sqrt, x); }
Recorded abs(const Recorded& x) { return function("fabs", std::fabs, x); }

Recorded Recording::made(std::string_view form, std::vector<Recorded> operands) {
  Recorded out;
  std::string key(form);
  for (const Recorded& operand : operands) {
    out.in = operand.in != nullptr ? operand.in : out.in;
    key += ' ' + (operand.node < 0 ? literal(operand.value) : 'v' + std::to_string(operand.node));
  }
  // A negative is its own inverse, and goes into sums.
  const auto negated = [&](const Recorded& x) {
    return x.node >= 0 && out.in->nodes_[static_cast<std::size_t>(x.node)].form == "-#";
  };
  const auto inner = [&](const Recorded& x) {
    return out.in->nodes_[static_cast<std::size_t>(x.node)].operands.front();
  };
  if (form == "-#" && negated(operands[0])) {
    return inner(operands[0]);
  }
  if (form == "# + #" && negated(operands[1])) {
    return operands[0] - inner(operands[1]);
  }
  if (form == "# + #" && negated(operands[0])) {
    return operands[1] - inner(operands[0]);
  }
  if (form == "# - #" && negated(operands[1])) {
    return operands[0] + inner(operands[1]);
  }
  if (form == "# * #" && (negated(operands[0]) || negated(operands[1]))) {
    return negated(operands[0]) ? -(inner(operands[0]) * operands[1]) : -(operands[0] * inner(operands[1]));
  }
  const auto [place, is_new] = out.in->known_.try_emplace(key, static_cast<int>(out.in->nodes_.size()));
  out.node = place->second;
  if (is_new) {
    out.in->nodes_.push_back({std::string(form), std::move(operands)});
  }
  return out;
}

Recorded Recording::input(const std::string& expression) {
  Recorded out;
  const auto [place, is_new] = known_.try_emplace(expression, static_cast<int>(nodes_.size()));
  out.node = place->second;
  out.in = this;
  if (is_new) {
    nodes_.push_back({expression, {}});
  }
  return out;
}

Eigen::VectorX<Recorded> Recording::inputs(const std::string& array, Eigen::Index count) {
  Eigen::VectorX<Recorded> out(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    out[k] = input(array + "[" + std::to_string(k) + "]");
  }
  return out;
}

void Recording::outputs(const std::string& array, const Eigen::VectorX<Recorded>& values) {
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    output(array + "[" + std::to_string(k) + "]", values[k]);
  }
}

// Nodes as they are written: values that are used once stand where they are used, others have names.
struct Recording::Printed {
  const std::vector<Node>& nodes;
  std::vector<int> uses;
  std::vector<std::string> names;

  explicit Printed(const std::vector<Node>& all) : nodes(all), uses(all.size(), 0), names(all.size()) {}

  [[nodiscard]] const Node& at(const Recorded& x) const { return nodes[static_cast<std::size_t>(x.node)]; }

  void use(const Recorded& x) {
    if (x.node >= 0 && uses[static_cast<std::size_t>(x.node)]++ == 0) {
      for (const Recorded& operand : at(x).operands) {
        use(operand);
      }
    }
  }

  [[nodiscard]] int operations(const Recorded& x) const {
    int out = 0;
    if (x.node >= 0 && names[static_cast<std::size_t>(x.node)].empty()) {
      out = 1;
      for (const Recorded& operand : at(x).operands) {
        out += operations(operand);
      }
    }
    return out;
  }

  // @param inside  another expression
  [[nodiscard]] std::string text(const Recorded& x, bool inside) const {
    if (x.node < 0) {
      return literal(x.value);
    }
    if (const std::string& name = names[static_cast<std::size_t>(x.node)]; !name.empty()) {
      return name;
    }
    const Node& node = at(x);
    const bool call = node.form.ends_with(')');
    std::string out;
    auto operand = node.operands.begin();
    for (const char c : node.form) {
      out += c == '#' && operand != node.operands.end() ? text(*operand++, !call) : std::string(1, c);
    }
    return inside && !call && !node.operands.empty() ? "(" + out + ")" : out;
  }
};

std::string Recording::statements(std::string_view indent) const {
  Printed printed(nodes_);
  for (const Output& output : outputs_) {
    printed.use(output.value);
  }
  std::string out;
  int count = 0;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Recorded node;
    node.node = static_cast<int>(k);
    const bool comparison = nodes_[k].form == "# > #";
    const bool many = printed.uses[k] > 1 || printed.operations(node) > most_in_a_row;
    if (printed.uses[k] > 0 && !comparison && (many || nodes_[k].operands.empty())) {
      const std::string name = "v" + std::to_string(count++);
      out.append(indent).append("const double ").append(name).append(" = ");
      out.append(printed.text(node, false)).append(";\n");
      printed.names[k] = name;
    }
  }
  for (const Output& output : outputs_) {
    out.append(indent).append(output.target).append(printed.text(output.value, false)).append(";\n");
  }
  return out;
}

std::string Recording::expression(const Recorded& value) const { return Printed(nodes_).text(value, false); }

}  // namespace rivid::detail
