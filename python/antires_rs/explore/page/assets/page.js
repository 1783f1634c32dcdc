// The page of `antires look`: shows what the server tells, sends what is clicked. Nothing else is asked of anyone.
"use strict";

const token = document.documentElement.dataset.token;
const $ = (id) => document.getElementById(id);
let state = null;
let shown = 0;
let figures = null; // what Bokeh embedded
let busy = 0;
let written = null; // band and orders that stand in their fields
// Both are on their way at once: what draws, and what is drawn.
const bokeh = new Promise((done) => {
  if (window.Bokeh) done();
  else document.getElementById("bokeh").addEventListener("load", done);
});

function address(path, more = {}) {
  return path + "?" + new URLSearchParams({ token, shown, ...more });
}

function say(text, wrong = false) {
  $("said").textContent = text;
  $("said").classList.toggle("wrong", wrong);
}

async function ask(path, body) {
  const options = body === undefined ? {} : { method: "POST", body: JSON.stringify(body) };
  let answer;
  try {
    answer = await fetch(address(path), options);
  } catch {
    throw new Error("The server has ended; start the command again.");
  }
  if (!answer.ok) throw new Error(await answer.text());
  const data = await answer.json();
  if (data.error) throw Object.assign(new Error(data.error), { taken: data.taken });
  return data;
}

// What is typed and clicked goes to the server in this order: "Save" after a reason saves the reason.
let line = Promise.resolve();
function inTurn(work) {
  const done = line.then(work, work);
  line = done;
  return done;
}

// The state that an answer tells, unless a newer one is shown already; of the response that is shown now.
async function take(told) {
  if (state && told.turn < state.turn) return;
  state = told.kind === "set" && told.dof !== shown ? await ask("state") : told;
}

async function act(command, body = {}, waiting = "") {
  busy += 1;
  if (waiting) say(waiting);
  $("said").classList.toggle("busy", Boolean(waiting));
  $("identify").disabled = true;
  try {
    const before = state;
    // Others need not wait for an identification.
    const told = await (command === "identify" ? ask("do/identify", body) : inTurn(() => ask("do/" + command, body)));
    await take(told);
    say(told.said);
    if (before && state.edits.length > before.edits.length && body.reason && $("reason").value === body.reason) {
      $("reason").value = ""; // it was that of this edit
    }
    write();
    // Another diagram stands behind the values: the figures are made anew, else only their marks move.
    const same = before && before.identified === state.identified && String(before.band_hz) === String(state.band_hz) &&
      before.max_order === state.max_order;
    if (same) mark();
    else await draw(false);
    return { done: true };
  } catch (error) {
    say(error.message, true);
    return { taken: error.taken };
  } finally {
    busy -= 1;
    $("said").classList.remove("busy");
    $("identify").disabled = busy > 0;
  }
}

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
  for (const one of document.querySelectorAll(".of-set")) one.hidden = state.kind !== "set";
  for (const one of document.querySelectorAll(".of-result")) one.hidden = state.kind !== "result";
  document.querySelector("main").classList.toggle("result", state.kind === "result");
  const warned = state.warnings || [];
  $("warnings").hidden = !warned.length;
  $("warnings").replaceChildren(...warned.map((text) => element("li", {}, text)));
  if (state.kind === "set") writeSet();
  else writeResult();
}

function writeSet() {
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
  $("undo").disabled = !state.can_undo;
  $("redo").disabled = !state.can_redo;
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

// Written anew only where they are others: a reason that is being typed, and the focus, stay.
function writeEdits() {
  $("none").hidden = state.edits.length > 0;
  const list = $("edits"), there = [...list.children].map((one) => one.dataset.edit);
  const wanted = state.edits.map((edit) => JSON.stringify([edit.text, edit.waits]));
  if (String(there) !== String(wanted)) {
    const typing = list.contains(document.activeElement) ? document.activeElement : null;
    const kept = typing && { at: typing.closest("li").dataset.edit, name: typing.tagName, value: typing.value, start: typing.selectionStart };
    list.replaceChildren(...state.edits.map((edit, number) => anEdit(edit, number, wanted[number])));
    const again = kept && [...list.children].find((one) => one.dataset.edit === kept.at)?.querySelector(kept.name);
    again?.focus();
    if (again && kept.name === "INPUT") {
      again.value = kept.value;
      again.setSelectionRange(kept.start, kept.start);
    }
  }
  [...list.children].forEach((one, number) => {
    const why = one.querySelector("input"), reason = state.edits[number].reason;
    if (why !== document.activeElement && why.dataset.said !== reason) why.value = reason;
    why.dataset.said = reason;
  });
}

function anEdit(edit, number, key) {
  const why = element("input", { value: edit.reason, maxlength: 1000, placeholder: "reason", "aria-label": "Reason: " + edit.text,
    "data-said": edit.reason, onchange: (event) => act("reword", { number, reason: event.target.value }) });
  const back = element("button", { type: "button", "aria-label": "Take back: " + edit.text, onclick: (event) => once(event, "take_back", { number }) }, "take back");
  const line = element("div", { class: "line" }, element("span", {}, edit.text), why, back);
  if (edit.waits) line.append(element("span", { class: "waits" }, `waits: ${edit.waits}; made again where it can be`));
  return element("li", { "data-edit": key }, line);
}

// The second click of a double click would hit what has moved into the place of the first.
function once(event, command, body) {
  if (event.detail < 2) act(command, body);
}

function writeResult() {
  $("tables").replaceChildren(...state.tables.flatMap((table) => {
    const numbers = table.head.map((text) => text.includes(", "));
    const cell = (name) => (text, i) => element(name, { class: numbers[i] ? "number" : null }, text);
    return [element("h2", {}, table.title), element("div", { class: "scroll" }, element("table", {},
      element("thead", {}, element("tr", {}, ...table.head.map(cell("th")))),
      element("tbody", {}, ...table.rows.map((row) => element("tr", {}, ...row.map(cell("td")))))))];
  }));
  $("answer").replaceChildren(...state.answer.map((text) => element("p", {}, text)));
}

// The marks of the values in every figure that has them.
function mark() {
  if (!figures) return;
  for (const root of figures.roots) {
    for (const one of root.model.references()) {
      if (state.marks[one.name]) one.data = { ...state.marks[one.name] };
      const kind = one.name?.startsWith("entry of ") ? one.name.slice(9) : null;
      if (kind) one.visible = state.marks[kind].freq.length > 0;
    }
  }
}

async function draw(anew = true, asked = null) {
  const place = $("pictures");
  const height = place.offsetHeight;
  const kept = anew ? null : range();
  const band = state.band_hz;
  try {
    if (state.kind === "result") return await drawResult(place);
    const made = await (asked ?? ask("figure"));
    await bokeh;
    place.style.minHeight = height + "px"; // what is below stays where it is
    clear();
    const target = element("div", { id: "evidence" });
    place.replaceChildren(target);
    figures = await Bokeh.embed.embed_item(made, target);
    for (const plot of plots()) listen(plot.model);
    if (kept && band && kept[0] >= band[0] && kept[1] <= band[1]) zoom(kept);
    place.dataset.drawn = shown;
    place.dataset.at ??= performance.timeOrigin + performance.now();
  } catch (error) {
    console.error(error);
    say(error.message, true);
  } finally {
    place.style.minHeight = "";
  }
}

async function drawResult(place) {
  const parts = state.figures.map((one, i) => element("figure", { "data-figure": i }, element("div"), element("figcaption", {}, one.caption)));
  place.replaceChildren(...parts);
  await bokeh;
  // Each when it comes into sight; the first ones at once.
  const sight = new IntersectionObserver((seen) => {
    for (const one of seen.filter((each) => each.isIntersecting)) {
      sight.unobserve(one.target);
      drawOne(one.target);
    }
  }, { rootMargin: "600px" });
  for (const part of parts) sight.observe(part);
}

async function drawOne(part) {
  try {
    const answer = await fetch(address("figure", { shown: part.dataset.figure }));
    const made = await answer.json();
    if (made.error) throw new Error(made.error);
    await Bokeh.embed.embed_item(made, part.firstChild);
    $("pictures").dataset.drawn = part.dataset.figure;
    part.dataset.there = "";
  } catch (error) {
    say(error.message, true);
  }
}

function clear() {
  if (!figures) return;
  for (const root of [...figures.roots]) {
    const at = Bokeh.documents.indexOf(root.model.document);
    root.remove();
    if (at >= 0) Bokeh.documents.splice(at, 1);
  }
  figures = null;
}

function plots() {
  const found = [];
  const walk = (view) => (view.frame ? found.push(view) : (view.child_views ?? []).forEach(walk));
  if (figures) figures.roots.forEach(walk);
  return found;
}

function range() {
  const plot = plots()[0];
  return plot ? [plot.model.x_range.start, plot.model.x_range.end] : null;
}

function zoom([start, end]) {
  const plot = plots()[0];
  if (plot) plot.model.x_range.setv({ start, end });
}

function listen(model) {
  model.on_event("tap", (event) => {
    const per = (range, pixels) => Math.abs(range.end - range.start) / Math.max(pixels, 1);
    act("click", { dof: shown, figure: model.name, x: event.x, y: event.y, reason: $("reason").value,
      x_per_px: per(model.x_range, model.inner_width), y_per_px: per(model.y_range, model.inner_height) });
  });
  model.document.event_manager.subscribed_models.add(model);
}

async function show(dof) {
  shown = (dof + state.dofs.length) % state.dofs.length;
  const kept = range();
  try {
    state = await ask("state");
    write();
    const row = document.querySelector("#values tr.shown");
    if (row) $("values").parentElement.scrollTop = row.offsetTop - 40; // of the table alone, not of the window
    await draw(kept === null);
  } catch (error) {
    say(error.message, true);
  }
}

// "12,5" is meant as 12.5.
function number(text) {
  const value = Number(text.trim().replace(",", "."));
  return text.trim() && Number.isFinite(value) ? value : null;
}

async function save() {
  const { taken } = await act("save");
  if (taken && confirm(`${$("said").textContent}\n\nReplace it?`)) await act("save", { replace: true });
}

function identify() {
  const low = number($("low").value), high = number($("high").value);
  const typed = $("order").value.trim(), order = typed ? number(typed) : null;
  if (low === null || high === null) return say("The band: two numbers in Hz.", true);
  if (typed && order === null) return say("The highest order: a whole number, or nothing.", true);
  return act("identify", { low_hz: low, high_hz: high, max_order: order }, "Identifying …");
}

function wire() {
  $("response").addEventListener("change", (event) => show(Number(event.target.value)));
  $("previous").addEventListener("click", () => show(shown - 1));
  $("next").addEventListener("click", () => show(shown + 1));
  $("undo").addEventListener("click", () => act("undo"));
  $("redo").addEventListener("click", () => act("redo"));
  $("save").addEventListener("click", save);
  $("controls").addEventListener("submit", (event) => {
    event.preventDefault();
    if (event.submitter?.id === "identify" && document.activeElement !== $("reason")) identify();
  });
  $("adding").addEventListener("submit", async (event) => {
    event.preventDefault();
    const value = number($("value").value);
    if (value === null) return say("A frequency in Hz.", true);
    if ((await act("add", { dof: shown, freq_hz: value, reason: $("reason").value })).done) $("value").value = "";
  });
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || state?.kind !== "set" || event.target.matches("input")) return;
    const key = event.key.toLowerCase();
    const meant = key === "s" ? save : key === "z" ? () => act(event.shiftKey ? "redo" : "undo") : key === "y" ? () => act("redo") : null;
    if (meant) {
      event.preventDefault();
      meant();
    }
  });
  addEventListener("beforeunload", (event) => {
    if (state?.unsaved && !ended) event.preventDefault();
  });
}

let ended = false;
function live() {
  // The server knows by this that the page is open, the page by its end that the server is not.
  const socket = new WebSocket("ws://" + location.host + "/alive?" + new URLSearchParams({ token }));
  socket.addEventListener("close", () => {
    ended = true;
    if (state) say("The server has ended; this page can be closed.", true);
  });
}

async function begin() {
  wire();
  live();
  try {
    const first = ask("figure");
    first.catch(() => {}); // told where it is waited for
    state = await ask("state");
    write();
    say(state.kind === "set" && !state.identified ? "Identifying …" : "");
    await draw(true, first);
    if (state.kind === "set" && !state.identified) await identify();
  } catch (error) {
    say(error.message, true);
  }
}

begin();
