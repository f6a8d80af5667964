// Draws the plots of the report: every .plot of the page says what it shows, #data holds the numbers.
(() => {
  "use strict";
  const root = document.documentElement;
  const data = JSON.parse(document.getElementById("data").textContent);
  const places = [...document.querySelectorAll(".plot")];
  const made = new Map(); // place → plot

  // ------------------------------------------------------------------ colours

  let colours = {};
  function read_colours() {
    const style = getComputedStyle(root);
    const value = (name) => style.getPropertyValue("--" + name).trim();
    colours = {};
    for (const name of ["text", "soft", "line", "grid", "measured", "predicted", "residual", "left-out"]) {
      colours[name] = value(name);
    }
    colours.series = value("series").split(",").map((c) => c.trim());
  }
  const series_colour = (i) => colours.series[i % colours.series.length];

  // ------------------------------------------------------------------ data

  function decoded(text) {
    const bytes = atob(text);
    const out = new Uint8Array(bytes.length);
    for (let k = 0; k < bytes.length; ++k) {
      out[k] = bytes.charCodeAt(k);
    }
    return new Float32Array(out.buffer);
  }

  // Instants and torques of a log, decoded once.
  const logs = data.logs.map(() => ({ joints: [], range: null }));
  function times(log) {
    const to = logs[log];
    if (!to.t) {
      const from = data.logs[log];
      to.t = Float64Array.from({ length: from.samples }, (_, k) => from.start + k * from.step);
    }
    return to.t;
  }
  function torques(log, joint) {
    const known = logs[log].joints;
    if (!known[joint]) {
      const from = data.logs[log].joints[joint];
      const measured = decoded(from.measured);
      const predicted = from.predicted === null ? null : decoded(from.predicted);
      known[joint] = { measured, predicted };
    }
    return known[joint];
  }
  // Instants and residuals of the rows of the fit, with a gap where rows are left out between them.
  function residuals(log, joint) {
    const { start, joints } = data.logs[log];
    const { step, per_sample, runs, residual } = joints[joint].rows;
    const values = decoded(residual);
    const t = [];
    const r = [];
    for (let k = 0, at = 0; k < runs.length; k += 2) {
      const first = start + runs[k] * per_sample;
      for (let i = 0; i < runs[k + 1]; ++i, ++at) {
        t.push(first + i * step);
        r.push(values[at]);
      }
      t.push(first + (runs[k + 1] - 0.5) * step);
      r.push(null);
    }
    return [t, r];
  }

  // ------------------------------------------------------------------ parts of plots

  const digits = (value, count) =>
    value === null || value === undefined || !Number.isFinite(value) ? "–" : String(Number(value.toPrecision(count)));

  function axis(label, more) {
    return {
      label,
      labelSize: 18,
      labelFont: "12px system-ui, sans-serif",
      font: "11px system-ui, sans-serif",
      stroke: colours.soft,
      grid: { stroke: colours.grid, width: 1 },
      ticks: { stroke: colours.line, width: 1, size: 4 },
      ...more,
    };
  }
  const x_axis = (label, more) => axis(label, { size: 28, gap: 3, ...more });
  // Of one width for all, so that plots under each other line up.
  const y_axis = (label, more) =>
    axis(label, { size: 52, gap: 3, space: 22, values: (u, ticks) => ticks.map((v) => (v === null ? "" : digits(v, 6))), ...more });
  const whole_numbers = { incrs: [1, 2, 5, 10, 20, 50, 100], space: 24 };

  function line(label, stroke, more) {
    return { label, stroke, width: 1.25, value: (u, v) => digits(v, 5), ...more };
  }
  function abscissa(label, count) {
    return { label, value: (u, v) => digits(v, count) };
  }

  // Stretches of samples that the fit leaves out, as a shade. Those narrower than a pixel are drawn as one.
  function shade(log, joint) {
    const runs = data.logs[log].joints[joint].left_out;
    const { start, step } = data.logs[log];
    return (u) => {
      const { ctx, bbox } = u;
      const end = bbox.left + bbox.width;
      const pixel = (k) => u.valToPos(start + k * step, "x", true);
      ctx.save();
      ctx.fillStyle = colours["left-out"];
      let drawn = bbox.left;
      for (let r = 0; r < runs.length; r += 2) {
        const from = Math.max(Math.floor(pixel(runs[r] - 0.5)), drawn);
        const to = Math.min(Math.ceil(pixel(runs[r] + runs[r + 1] - 0.5)), end);
        if (to > from) {
          ctx.fillRect(from, bbox.top, to - from, bbox.height);
          drawn = to;
        }
      }
      ctx.restore();
    };
  }

  // All plots of a log show the same time.
  function follow(log) {
    return (u, scale) => {
      const { min, max } = u.scales.x;
      const known = logs[log].range;
      if (scale !== "x" || min === null || (known && known.min === min && known.max === max)) {
        return;
      }
      logs[log].range = { min, max };
      for (const plot of made.values()) {
        if (plot !== u && plot.rivid_log === log) {
          plot.setScale("x", { min, max });
        }
      }
    };
  }

  function time_plot(log, joint, height, x_label, label, series, values, t = times(log)) {
    const all = times(log);
    const range = logs[log].range || { min: all[0], max: all[all.length - 1] };
    return {
      options: {
        height,
        scales: { x: { time: false, ...range } },
        axes: [x_axis(x_label, x_label ? {} : { labelSize: 0 }), y_axis(label)],
        series: [abscissa("t", 7), ...series],
        cursor: {
          drag: { x: true, y: false, dist: 4 },
          sync: {
            key: "log " + log,
            scales: ["x", null],
            filters: { pub: (type) => type === "mousemove" || type === "mouseleave" },
          },
        },
        hooks: { drawClear: [shade(log, joint)], setScale: [follow(log)] },
      },
      values: [t, ...values],
      log,
    };
  }

  function over_iterations(height, label, series, lists, logarithmic) {
    const count = lists[0].length;
    const positive = (v) => (v !== null && (v > 0 || !logarithmic) ? v : null);
    return {
      options: {
        height,
        scales: { x: { time: false }, y: logarithmic ? { distr: 3, log: 10 } : {} },
        axes: [x_axis("iteration", whole_numbers), y_axis(label)],
        series: [abscissa("iteration", 4), ...series],
      },
      values: [Array.from({ length: count }, (_, k) => k), ...lists.map((list) => list.map(positive))],
    };
  }

  const roughness = (list) => list.reduce((sum, v, k) => sum + (k > 0 ? (v - list[k - 1]) ** 2 : 0), 0);

  // ------------------------------------------------------------------ kinds of plots

  const kinds = {
    torque(log, joint) {
      const { measured, predicted } = torques(log, joint);
      const lines = [["measured", measured]];
      if (predicted) {
        lines.push(["predicted", predicted]);
      }
      // The rougher one behind, where it would hide the other; as a broader line, if both are alike.
      const rough = lines.map(([, values]) => roughness(values));
      if (rough[1] > rough[0]) {
        lines.reverse();
      }
      const alike = Math.max(...rough) < 4 * Math.min(...rough);
      const series = lines.map(([name], i) => line(name, colours[name], { width: alike && i === 0 ? 2.5 : 1.25 }));
      const values = lines.map(([, list]) => list);
      // The residual below has the label of the time.
      return time_plot(log, joint, 220, predicted ? null : "t [s]", "τ [" + data.joints[joint].unit + "]", series, values);
    },

    residual(log, joint) {
      const unit = data.joints[joint].unit;
      const [t, values] = residuals(log, joint);
      return time_plot(log, joint, 130, "t [s]", "[" + unit + "]", [line("residual of rows", colours.residual, { width: 1 })], [values], t);
    },

    histogram(log, joint) {
      const shape = data.residuals[joint];
      const centres = shape.counts.map((_, k) => shape.first_edge + (k + 0.5) * shape.bin);
      return {
        options: {
          height: 170,
          scales: { x: { time: false, range: (u, min, max) => [min - shape.bin, max + shape.bin] } },
          axes: [x_axis("residual [" + data.joints[joint].unit + "]"), y_axis("rows")],
          series: [
            abscissa("residual", 3),
            line("rows", colours.residual, {
              fill: colours["left-out"],
              paths: uPlot.paths.bars({ size: [1, Infinity] }),
              points: { show: false },
            }),
            line("normal", colours.predicted, { paths: uPlot.paths.spline(), points: { show: false } }),
          ],
        },
        values: [centres, shape.counts, shape.normal],
      };
    },

    autocorrelation(log, joint) {
      const { autocorrelation, white_noise: bound } = data.residuals[joint];
      const level = (value) => autocorrelation.map(() => value);
      const dashed = { dash: [4, 4], width: 1, points: { show: false } };
      return {
        options: {
          height: 170,
          scales: {
            x: { time: false, range: () => [0.5, autocorrelation.length + 0.5] },
            y: { range: (u, min, max) => [Math.min(min, -2 * bound), Math.max(max, 2 * bound)] },
          },
          axes: [x_axis("lag [rows]", whole_numbers), y_axis("autocorrelation")],
          series: [
            abscissa("lag", 3),
            line("autocorrelation", colours.residual, {
              fill: colours.residual,
              paths: uPlot.paths.bars({ size: [0.5, 6] }),
              points: { show: false },
            }),
            line("white noise", colours.soft, dashed),
            line("", colours.soft, { ...dashed, class: "hidden" }),
          ],
        },
        values: [autocorrelation.map((_, k) => k + 1), autocorrelation, level(bound), level(-bound)],
      };
    },

    "torque-error"() {
      const { error, joint_error } = data.iterations;
      return over_iterations(
        260,
        "error [%]",
        [
          line("all", colours.text, { width: 2 }),
          ...data.joints.map((joint, j) => line(joint.name, series_colour(j), { dash: [6, 3] })),
        ],
        [error, ...joint_error],
        true,
      );
    },

    "motion-error"(log, joint) {
      const { to_measured, to_reference } = data.iterations;
      const orders = ["q", "q̇", "q̈"];
      return over_iterations(
        220,
        "error [%]",
        [
          ...orders.map((q, i) => line(q, series_colour(i))),
          ...orders.map((q, i) => line(q + " ref.", series_colour(i), { dash: [5, 4] })),
        ],
        [...to_measured, ...to_reference].map((order) => order[joint]),
        true,
      );
    },
  };

  // ------------------------------------------------------------------ making them

  let paper_width = null; // of plots on paper

  function make(place) {
    const { kind, joint, log } = place.dataset;
    const plan = kinds[kind](Number(log), Number(joint));
    if (made.has(place)) {
      made.get(place).destroy();
    }
    const plot = new uPlot({ width: width_of(place), ...plan.options }, plan.values, place);
    plot.rivid_log = plan.log;
    made.set(place, plot);
    place.plot = plot; // for whoever looks from the console
  }

  function width_of(place) {
    return paper_width ? Math.min(place.clientWidth, paper_width / (place.closest(".pairs") ? 2.1 : 1)) : place.clientWidth;
  }

  // A few at a time, so that the page can be read meanwhile.
  function make_all() {
    const waiting = places.filter((place) => !made.has(place));
    const some = () => {
      const until = performance.now() + 40;
      while (waiting.length > 0 && performance.now() < until) {
        make(waiting.shift());
      }
      if (waiting.length > 0) {
        setTimeout(some);
      } else {
        root.dataset.plots = made.size;
        root.dataset.ready = Math.round(performance.now());
      }
    };
    some();
  }

  function make_again() {
    read_colours();
    places.forEach(make);
  }

  // ------------------------------------------------------------------ what the reader does

  const moves = {
    in: (a, b) => [a + 0.25 * (b - a), b - 0.25 * (b - a)],
    out: (a, b) => [a - 0.5 * (b - a), b + 0.5 * (b - a)],
    back: (a, b) => [a - 0.5 * (b - a), b - 0.5 * (b - a)],
    forward: (a, b) => [a + 0.5 * (b - a), b + 0.5 * (b - a)],
    all: () => [-Infinity, Infinity],
  };
  function move(log, how) {
    const t = times(log);
    const first = t[0];
    const last = t[t.length - 1];
    const shown = logs[log].range || { min: first, max: last };
    let [min, max] = moves[how](shown.min, shown.max);
    const span = Math.max(Math.min(max - min, last - first), 4 * data.logs[log].step);
    min = Math.max(Math.min(min, last - span), first);
    logs[log].range = { min, max: Math.min(min + span, last) };
    for (const plot of made.values()) {
      if (plot.rivid_log === log) {
        plot.setScale("x", logs[log].range);
      }
    }
  }
  for (const toolbar of document.querySelectorAll(".toolbar")) {
    toolbar.addEventListener("click", (event) => {
      if (event.target.dataset.move) {
        move(Number(toolbar.dataset.log), event.target.dataset.move);
      }
    });
  }

  new ResizeObserver(() => {
    for (const [place, plot] of made) {
      if (!paper_width && place.clientWidth !== plot.width) {
        plot.setSize({ width: place.clientWidth, height: plot.height });
      }
    }
  }).observe(document.querySelector("main"));

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", make_again);
  addEventListener("beforeprint", () => {
    root.classList.add("paper");
    paper_width = 700;
    make_again();
  });
  addEventListener("afterprint", () => {
    root.classList.remove("paper");
    paper_width = null;
    make_again();
  });

  read_colours();
  make_all();
})();
