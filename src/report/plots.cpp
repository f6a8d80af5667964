#include <algorithm>
#include <bit>
#include <cstring>

#include "experiment/json_fields.hpp"
#include "report/document.hpp"
#include "report/markup.hpp"
#include "rivid/text.hpp"

// A plot is a figure with a caption, and its numbers under the identifier of the figure; report.js draws it.
namespace rivid::detail {

namespace {

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const auto byte = [&](std::size_t i) {
      return i < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) : 0U;
    };
    const std::uint32_t group = (byte(k) << 16U) | (byte(k + 1) << 8U) | byte(k + 2);
    out += digits[group >> 18U];
    out += digits[(group >> 12U) & 63U];
    out += k + 1 < bytes.size() ? digits[(group >> 6U) & 63U] : '=';
    out += k + 2 < bytes.size() ? digits[group & 63U] : '=';
  }
  return out;
}

// In base64, in double or in single precision.
std::string encoded(const Vector& values, bool exact) {
  static_assert(std::endian::native == std::endian::little, "scripts read the low byte first");
  const auto bytes = [](const auto& numbers) {
    std::string out(static_cast<std::size_t>(numbers.size()) * sizeof(numbers[0]), '\0');
    std::memcpy(out.data(), numbers.data(), out.size());
    return base64(out);
  };
  return exact ? bytes(values) : bytes(Eigen::VectorXf(values.cast<float>()));
}

// Series that share their abscissa have it once: the number of the series that has it stands in its place.
Json data_of(const Chart& chart, std::size_t index) {
  const Series& series = chart.series[index];
  Json out = {{"name", series.name},
              {"style", series.style},
              {"kind", rivid::name(series.kind)},
              {"exact", series.exact}};
  std::size_t same = 0;
  while (chart.series[same].x.size() != series.x.size() || chart.series[same].x != series.x) {
    ++same;
  }
  // Single precision of a clock that began long ago has no fractions of a second.
  constexpr double far = 4096.0;
  const bool fine = series.x.size() > 0 && series.x.cwiseAbs().maxCoeff() > far;
  out["fine"] = fine;
  out["x"] = same < index ? Json(same) : Json(encoded(series.x, fine));
  out["y"] = encoded(series.y, series.exact);
  if (series.upper.size() > 0) {
    out["upper"] = encoded(series.upper, series.exact);
  }
  if (series.on_demand) {
    out["on_demand"] = true;
  }
  if (!series.in_legend) {
    out["unnamed"] = true;
  }
  return out;
}

Json data_of(const Chart& chart) {
  const auto of_rule = [](const Rule& rule) {
    return Json{{"upright", rule.upright}, {"at", rule.at}, {"style", rule.style}};
  };
  const auto of_series = [&](std::size_t k) { return data_of(chart, k); };
  return {{"x", chart.x_label},
          {"y", chart.y_label},
          {"logarithmic", chart.logarithmic},
          {"x_shown", chart.x_shown},
          {"y_shown", chart.y_shown},
          {"height", chart.height},
          {"rules", json_list(chart.rules, of_rule)},
          {"series", json_list(places(chart.series.size()), of_series)}};
}

Json data_of(const HeatMap& map) {
  const Matrix rows = map.values.transpose();
  return {{"names", map.names}, {"values", encoded(rows.reshaped(), false)}};
}

Json data_of(const Skeleton& skeleton) {
  const auto points = [](const std::vector<Eigen::Vector3d>& of) {
    return json_list(of, [](const Eigen::Vector3d& point) { return json_of(point); });
  };
  const auto body = [](const Skeleton::Ellipsoid& of) {
    return Json{{"name", of.name},
                {"style", of.style},
                {"mass", of.mass},
                {"centre", json_of(of.centre)},
                {"axes", json_of(Vector(of.axes.reshaped()))}};
  };
  const auto trace = [&](const Skeleton::Trace& of) {
    return Json{{"name", of.name}, {"style", of.style}, {"points", points(of.points)}};
  };
  const auto pose = [&](const Skeleton::Pose& of) {
    return Json{{"t", of.t}, {"joints", points(of.joints)}};
  };
  return {{"joints", points(skeleton.joints)},
          {"bodies", json_list(skeleton.ellipsoids, body)},
          {"traces", json_list(skeleton.traces, trace)},
          {"poses", json_list(skeleton.poses, pose)}};
}

Json data_of(const DotPlot& plot) {
  Json rows = {{"", plot.x_label, "from", "to"}};
  for (const DotPlot::Dot& dot : plot.dots) {
    rows.push_back({dot.name, dot.interval.value, dot.interval.low, dot.interval.high});
  }
  return {{"rows", std::move(rows)},
          {"off", json_list(plot.dots, [](const DotPlot::Dot& dot) { return dot.mark == Mark::bad; })},
          {"reference", plot.reference},
          {"wanted", plot.wanted}};
}

Json data_of(const PathPlot& plot) { return {{"steps", plot.steps}, {"interval", json_of(plot.interval)}}; }

template <typename Take>
void for_each_plot(const std::vector<Block>& blocks, const Take& take) {
  for (const Block& block : blocks) {
    if (const auto* const plots = std::get_if<Plots>(&block.content)) {
      for (const Plots::Group& group : plots->groups) {
        for (const Plot& plot : group.plots) {
          std::visit(take, plot);
        }
      }
    }
  }
}

}  // namespace

std::string markup_of(const Plot& plot) {
  return std::visit(
      [](const auto& of) {
        // NOLINTNEXTLINE(misc-const-correctness): that of bars has no `log`
        std::string attributes = "class=\"" + std::string(of.style()) + "\" id=\"" + escaped(of.id) + "\"";
        if constexpr (requires { of.log; }) {
          attributes += of.log ? " data-log=\"" + std::to_string(*of.log) + "\"" : "";
        }
        const std::string caption =
            element("b", escaped(of.title)) + (of.remark.empty() ? "" : " " + escaped(of.remark));
        return element("figure", element("figcaption", caption) + element("div", "", "class=\"picture\""),
                       attributes) +
               "\n";
      },
      plot);
}

std::string markup_of(const Interval& interval) {
  const std::string values = number(interval.low, 9) + " " + number(interval.high, 9) + " " +
                             number(interval.value, 9) + " " + number(interval.reference, 9);
  return element(
      "span", "",
      "class=\"interval-bar\" data-values=\"" + values + "\" data-label=\"" + escaped(interval.label) + "\"");
}

std::string data_of(const Document& document) {
  Json out = Json::object();
  const auto add = [&](const auto& plot) {
    Json& data = out[plot.id] = data_of(plot);
    data["label"] = plot.label;
  };
  for_each_plot(document.first_look, add);
  for (const Section& section : document.sections) {
    for_each_plot(section.blocks, add);
  }
  // Nothing in it may end the <script>.
  std::string text = out.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

}  // namespace rivid::detail
