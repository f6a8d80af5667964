// Formulas, which arithmatex leaves as \[TeX\] and \(TeX\), by KaTeX.
for (const formula of document.querySelectorAll(".arithmatex")) {
  const tex = formula.textContent;
  katex.render(tex.slice(2, -2), formula, { displayMode: tex.startsWith("\\[") });
}
