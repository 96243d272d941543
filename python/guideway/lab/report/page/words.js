// Numbers and names of experiments as text, and what all parts of the page share.

const VERDICTS = {
  holds: { tone: "good", sign: "good", name: "holds" },
  "does not hold": { tone: "bad", sign: "bad", name: "does not hold" },
  "cannot be judged": { tone: "none", sign: "none", name: "cannot be judged" },
};
const verdictOf = (claim) => VERDICTS[claim.verdict] || VERDICTS["cannot be judged"];
const badge = (tone, kind) => make("span", { class: `badge small ${tone}` }, sign(kind));

const minus = (text) => text.replace("-", "\u2212");

/** A value with the digits of its measure. */
function digitsOf(metric, value) {
  if (!finite(value)) return "\u2013";
  if (value !== 0 && Math.abs(value) < 0.5 * 10 ** -metric.digits) return minus(value.toExponential(1));
  return minus(value.toFixed(Math.abs(value) >= 1e6 ? 0 : metric.digits));
}

/** Seconds in the unit that suits them. */
function seconds(value) {
  if (!finite(value)) return "\u2013";
  if (value >= 100) return `${value.toFixed(0)} s`;
  if (value >= 1) return `${value.toFixed(2)} s`;
  return value >= 1e-3 ? `${(value * 1e3).toFixed(value >= 0.1 ? 0 : 1)} ms` : `${(value * 1e6).toFixed(0)} \u00b5s`;
}

/** A count or size without needless digits. */
const count = (value) => (finite(value) ? Math.round(value).toString().replace(/\B(?=(\d{3})+$)/g, "\u202f") : "\u2013");
/** A tick of a logarithmic axis. */
const power = (value) => (value >= 9.99e3 || value < 9.99e-3 ? `1e${Math.round(Math.log10(value))}` : String(+value.toPrecision(3)));
const pValue = (p) => (!finite(p) ? "\u2013" : p < 1e-4 ? `< 10${String(Math.max(-99, Math.ceil(Math.log10(p || 1e-99)))).replace("-", "\u207b").replace(/\d/g, (d) => "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"[d])}` : p.toPrecision(2));
const plural = (n, word) => `${count(n)} ${word}${n === 1 ? "" : "s"}`;

/** World and query in a word. */
const placeName = (world, query) => (query ? `${world} \u00b7 ${query}` : world);
const metricName = (metric) => words(metric.name);
const headed = (metric) => (metric.unit ? `${metricName(metric)}, ${metric.unit}` : metricName(metric));

/** Colour of a method: ten that are told apart, then the same with dashes. */
const INKS = 10;
const DASHES = ["", "7 4", "2 3", "9 3 2 3"];
const ink = (k) => `var(--entry-${k % INKS})`;
const dash = (k) => DASHES[Math.floor(k / INKS) % DASHES.length];

/** A named constant colour at this moment. */
const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** A heading with something beside it. */
const section = (title, note, ...children) => make("section", { class: "block" }, make("header", { class: "caption" }, make("h3", {}, title), note ? make("p", { class: "hint" }, note) : null), ...children);

/** A select of choices [[value, text]], or null if there is nothing to choose. */
function chooser(label, choices, value, change) {
  if (choices.length < 2) return null;
  const node = make("select", { "aria-label": label, onchange: () => change(node.value) }, ...choices.map(([key, text]) => make("option", { value: key, selected: key === value }, text)));
  return make("label", { class: "chooser" }, make("span", {}, label), node);
}

/** Buttons of which one is pressed. */
function switches(label, choices, value, change) {
  const group = make("div", { class: "chips", role: "group", "aria-label": label });
  const paint = (now) => group.replaceChildren(...choices.map(([key, text]) => make("button", { type: "button", "aria-pressed": String(key === now), onclick: () => { paint(key); change(key); group.querySelector("[aria-pressed=true]").focus(); } }, text)));
  paint(value);
  return group;
}
