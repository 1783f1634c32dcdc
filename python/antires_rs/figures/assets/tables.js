// What stands beside the figures: the values and the edits. page.js says when it is written.
"use strict";

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value !== null && value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

// As many decimals that the typical error has two digits.
function decimals(rows) {
  const errors = rows.map((row) => row.std_hz).filter((error) => error > 0).sort((a, b) => a - b);
  if (!errors.length) return 3;
  return Math.min(6, Math.max(3, Math.ceil(-Math.log10(errors[errors.length >> 1])) + 1));
}

function write() {
  document.title = state.title || document.title;
  if (state.title) $("title").textContent = state.title;
  for (const one of document.querySelectorAll(".of-set")) one.hidden = false;
  $("warnings").hidden = !state.warnings.length;
  $("warnings").replaceChildren(...state.warnings.map((text) => element("li", {}, text)));
  if ($("response").options.length !== state.dofs.length) {
    $("response").replaceChildren(...state.dofs.map((name, i) => element("option", { value: i }, "dof " + name)));
  }
  $("response").value = shown;
  for (const one of document.querySelectorAll(".needs-source")) one.hidden = !state.can_identify;
  // What is being typed there stays until the band is another one.
  const options = String([state.band_hz, state.max_order]);
  if (options !== written) {
    written = options;
    if (state.band_hz) {
      $("low").value = +state.band_hz[0].toPrecision(6);
      $("high").value = +state.band_hz[1].toPrecision(6);
    }
    $("order").value = state.max_order ?? "";
  }
  $("identify").textContent = state.identified ? "Identify again" : "Identify";
  $("save").hidden = !state.file;
  $("save").textContent = state.unsaved ? "Save *" : "Save";
  $("download").href = address("download");
  const unsaved = state.unsaved ? "There are edits that are not saved. " : "";
  $("file").textContent = state.file ? `${unsaved}Save writes ${state.file}` : "";
  $("adding-at").textContent = "at dof " + state.dofs[shown];
  writeValues();
  writeEdits();
}

function writeValues() {
  const rows = [], digits = decimals(state.rows);
  // Long names have a line of their own above their values.
  const wide = state.dofs.some((name) => name.length > 9);
  $("values").classList.toggle("wide", wide);
  state.dofs.forEach((name, dof) => {
    const own = state.rows.filter((row) => row.dof === dof);
    const lines = own.length ? own : [null];
    lines.forEach((row, i) => {
      const go = element("button", { type: "button", onclick: () => show(dof), "aria-label": "Show dof " + name, title: name }, name);
      if (wide && !i) rows.push(element("tr", { class: dof === shown ? "first shown" : "first" }, element("td", { class: "dof", colspan: 6 }, go)));
      const kind = [i || wide ? "" : "first", dof === shown ? "shown" : ""].join(" ");
      const named = wide ? [] : [element("td", { class: "dof" }, ...(i ? [] : [go]))];
      if (!row) {
        rows.push(element("tr", { class: kind }, ...named, element("td", { class: "number" }, "–"), element("td", { colspan: 5 })));
        return;
      }
      const hz = row.freq_hz.toFixed(digits);
      const drop = element("button", { type: "button", "aria-label": `Drop ${hz} Hz at dof ${name}`, title: "Drop this value",
        onclick: (event) => once(event, "drop", { dof, freq_hz: row.freq_hz, reason: $("reason").value }) }, "×");
      rows.push(element("tr", { class: kind, "data-dof": name },
        ...named,
        element("td", { class: "number hz" }, hz),
        element("td", { class: "number" }, row.std_hz === null ? "" : (+row.std_hz.toPrecision(2)).toFixed(digits)),
        element("td", { class: "number" }, row.damping_percent === null ? "" : row.damping_percent.toFixed(2)),
        element("td", {}, row.grade),
        element("td", { class: "doubts" }, row.doubts),
        element("td", { class: "drop" }, drop)));
    });
  });
  $("values").tBodies[0].replaceChildren(...rows);
}

function writeEdits() {
  $("none").hidden = state.edits.length > 0;
  $("edits").replaceChildren(...state.edits.map((edit, number) => {
    const back = element("button", { type: "button", "aria-label": "Take back: " + edit.text, onclick: (event) => once(event, "take_back", { number }) }, "take back");
    const waits = edit.waits ? [element("span", { class: "waits" }, `waits: ${edit.waits}; made again where it can be`)] : [];
    return element("li", {}, element("div", { class: "line" }, element("span", {}, edit.text), back, ...waits));
  }));
}

// The second click of a double click would hit what has moved into the place of the first.
function once(event, command, body) {
  if (event.detail < 2) act(command, body);
}
