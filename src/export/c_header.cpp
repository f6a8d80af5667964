#include "rivid/export/c_header.hpp"

#include <algorithm>
#include <cctype>

#include "export/c_functions.hpp"
#include "export/recorded.hpp"
#include "joined.hpp"
#include "rivid/error.hpp"
#include "rivid/online/momentum.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::Recorded;
using detail::Recording;
using Values = Eigen::VectorX<Recorded>;
using Momentum = detail::Momentum<Recorded>;

// Statements that work() records.
template <typename Work>
std::string recorded(const Work& work, std::string_view indent = "  ") {
  Recording recording;
  work(recording);
  return recording.statements(indent);
}

// v_s of the joints where they are given, else 0.
Values smoothing_speeds(Recording& in, Index n) {
  Values out(n);
  for (Index j = 0; j < n; ++j) {
    out[j] = in.input("smoothing_speed ? smoothing_speed[" + std::to_string(j) + "] : 0.0");
  }
  return out;
}

std::string rigid_body(const ModelData& model) {
  return recorded([&](Recording& in) {
    const Index n = model.size();
    Values tau(n);
    BasicInverseDynamics<Recorded>(model).rigid_body(in.inputs("q", n), in.inputs("qd", n),
                                                     in.inputs("qdd", n), tau);
    in.outputs("tau", tau);
  });
}

std::string gravity(const ModelData& model) {
  return recorded([&](Recording& in) {
    Values tau(model.size());
    BasicInverseDynamics<Recorded>(model).gravity(in.inputs("q", model.size()), tau);
    in.outputs("tau", tau);
  });
}

std::string friction(const ModelData& model) {
  return recorded([&](Recording& in) {
    const Index n = model.size();
    const Values v_s = detail::smoothing_of_elements(model, smoothing_speeds(in, n).data());
    Values tau(n);
    detail::friction_of(model, in.inputs("qd", n).data(), v_s.data(), tau.data());
    in.outputs("tau", tau);
  });
}

// All friction, with its sign as it is, on top of the torques without it.
std::string with_friction(const ModelData& model) {
  return recorded([&](Recording& in) {
    const Index n = model.size();
    const Values sharp = Values::Constant(std::ssize(model.dry_friction), Recorded(0.0));
    const Values tau = in.inputs("tau", n);
    Values total = in.inputs("friction", n);
    detail::add_load_friction(model, tau.data(), in.inputs("qd", n).data(), sharp.data(), total.data());
    in.outputs("tau", Values(total + tau));
  });
}

std::string of_joint(const char* array, std::size_t j) { return array + ("[" + std::to_string(j) + "]"); }

// The numbers of a link or a load, one after the other.
template <typename Numbers>
Eigen::Map<Values> all_of(Numbers& numbers) {
  return {reinterpret_cast<Recorded*>(&numbers), sizeof(Numbers) / sizeof(Recorded)};
}

std::string sweep(const ModelData& model) {
  return recorded([&](Recording& in) {
    Momentum momentum(model);
    const Index n = model.size();
    momentum.sweep(in.inputs("q", n).data(), in.inputs("qd", n).data());
    for (std::size_t j = 0; j < momentum.links.size(); ++j) {
      in.output(of_joint("to->c", j), momentum.frames.turns[j].c);
      in.output(of_joint("to->s", j), momentum.frames.turns[j].s);
      in.output(of_joint("to->q", j), in.input(of_joint("q", j)));
      in.outputs(of_joint("to->link", j), all_of(momentum.links[j]));
    }
  });
}

// Link j from what the sweep left.
Momentum at_link(const ModelData& model, Recording& in, std::size_t j) {
  Momentum out(model);
  auto link = all_of(out.links[j]);
  link = in.inputs(of_joint("at->link", j), link.size());
  if (out.frames.link(j).revolute) {
    out.frames.turns[j] = {in.input(of_joint("at->c", j)), in.input(of_joint("at->s", j))};
  } else {
    out.frames.turns[j] = detail::with_theta(out.frames.link(j), detail::CosSin<Recorded>{1.0, 0.0});
    out.frames.set_way(j, in.input(of_joint("at->q", j)));
  }
  return out;
}

std::string shares(const ModelData& model) {
  std::string out;
  for (std::size_t j = 0; j < model.chain.links.size(); ++j) {
    const auto share = [&](Recording& in) {
      Momentum::Load load;
      all_of(load) = in.inputs("load", all_of(load).size());
      Recorded p;
      Recorded rate;
      load = at_link(model, in, j).share(j, load, p, rate);
      in.output(of_joint("p", j), p);
      in.output(of_joint("rate", j), rate);
      if (j > 0) {
        in.outputs("load", all_of(load));
      }
    };
    out += "    case " + std::to_string(j) + ": {\n" + recorded(share, "      ") + "      break;\n    }\n";
  }
  return out;
}

std::string body_on_last_link(const ModelData& model) {
  return recorded([&](Recording& in) {
    const std::size_t last = model.chain.links.size() - 1;
    const Values body = in.inputs("body", inertial_count);
    auto load = Momentum::of_body(at_link(model, in, last).links[last], body.data());
    in.outputs("load", all_of(load));
  });
}

std::string rotors(const ModelData& model) {
  return recorded([&](Recording& in) {
    const Index n = model.size();
    Values p = in.inputs("p", n);
    detail::add_product(model.rotor, in.inputs("qd", n).data(), p.data());
    in.outputs("p", p);
  });
}

std::string passed_on(const ModelData& model) {
  return recorded([&](Recording& in) {
    const Index n = model.size();
    const Values v_s = smoothing_speeds(in, n);
    const Values qd = in.inputs("qd", n);
    Values torque = in.inputs("driven", n);
    for (const DryFriction& element : model.dry_friction) {
      const Index j = element.joint();
      const Recorded own = element.sign_speed > 0.0 ? Recorded(element.sign_speed) : v_s[j];
      torque[j] = detail::passed_on(element.load, own, torque[j], qd[j]);
    }
    in.outputs("driven", torque);
  });
}

std::string low_pass() {
  return recorded([](Recording& in) {
    const auto x = [&](const char* name) { return in.input(name); };
    in.returned(detail::low_pass(x("r"), x("keep"), x("before"), x("now"), x("driven"), x("f_m")));
  });
}

std::string last_axes(const ModelData& model) {
  const Eigen::Matrix3d axes = link_axes(model.chain.links.back());
  const auto row = [](const auto& of) { return "{" + detail::joined(of, ", ", exact) + "}"; };
  return "{" + detail::joined(axes.rowwise(), ", ", row) + "}";
}

// A text that can stand in a comment.
std::string commented(std::string_view text) {
  std::string out = on_one_line(text);
  for (std::size_t at = out.find("*/"); at != std::string::npos; at = out.find("*/")) {
    out.replace(at, 2, "* /");
  }
  return out;
}

bool is_identifier(std::string_view text) { return !text.empty() && c_identifier(text) == text; }

void replace_all(std::string& text, std::string_view what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
}

}  // namespace

std::string c_identifier(std::string_view text) {
  std::string out(text);
  const auto is_ascii = [](unsigned char c) { return c < 128 && (std::isalnum(c) != 0 || c == '_'); };
  std::ranges::replace_if(out, [&](char c) { return !is_ascii(static_cast<unsigned char>(c)); }, '_');
  const bool digit = !out.empty() && out.front() >= '0' && out.front() <= '9';
  return digit ? "_" + out : out;
}

std::string c_header(const DynamicModel& model, std::string_view name, std::string_view origin) {
  require_chain("c_header", model.chain());
  if (!is_identifier(name)) {
    throw InputError("c_header: name is " + in_quotes(name) +
                     ", must be a C identifier: letters, digits and _, no digit first");
  }
  const std::string joints = detail::joined(model.joints(), ", ", &Joint::name);
  std::string body(detail::c_functions);
  const ModelData& data = model;
  for (const auto& [mark, text] : std::initializer_list<std::pair<std::string_view, std::string>>{
           {"$joints$", std::to_string(model.size())},
           {"$last_axes$", last_axes(data)},
           {"$rigid_body$\n", rigid_body(data)},
           {"$gravity$\n", gravity(data)},
           {"$friction$\n", friction(data)},
           {"$with_friction$\n", with_friction(data)},
           {"$sweep$\n", sweep(data)},
           {"$shares$\n", shares(data)},
           {"$body$\n", body_on_last_link(data)},
           {"$rotors$\n", rotors(data)},
           {"$passed_on$\n", passed_on(data)},
           {"$low_pass$\n", low_pass()},
           {"@", std::string(name)}}) {
    replace_all(body, mark, text);
  }
  return "/* Torques of a robot, written by rivid" +
         (origin.empty() ? std::string() : ": " + commented(origin)) + ".\n * Joints: " + commented(joints) +
         ".\n * SI units on the joint side: q [rad | m], qd, qdd by seconds, tau [N m | N]. */\n" + body;
}

}  // namespace rivid
