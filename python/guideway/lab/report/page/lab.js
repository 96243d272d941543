// The page: what is shown, the list of experiments, theme.

const data = record(JSON.parse(document.getElementById("data").textContent));
const all = list(data.experiments);
const [content, side] = [document.getElementById("content"), document.getElementById("side")];

const go = (name) => {
  const there = `#${encodeURIComponent(name)}`;
  if (location.hash !== there) location.hash = there;
  else route();
};

function sideOf(current) {
  const link = (name, title, marks, key) => make("a", { href: `#${encodeURIComponent(key)}`, "aria-current": key === current ? "page" : null, onclick: (event) => { event.preventDefault(); go(key); menu(false); } }, make("span", { class: "side-title" }, title), marks);
  const marksOf = (e) => make("span", { class: "marks" }, ...["holds", "does not hold", "cannot be judged"].filter((v) => e.claims.some((c) => c.verdict === v)).map((v) => make("i", { class: VERDICTS[v].tone, title: `${e.claims.filter((c) => c.verdict === v).length} ${v}` }, String(e.claims.filter((c) => c.verdict === v).length))), e.alarms.length ? make("i", { class: "bad alarm-mark", title: "alarm" }, "!") : null);
  const groups = list(data.sources).map(([key]) => key);
  side.replaceChildren(link("overview", "Overview", null, ""), ...groups.flatMap((source) => [make("h2", {}, sourceName(data, source, false)), ...all.filter((e) => e.source === source).map((e) => link(e.name, e.title, marksOf(e), e.name))]));
}

function route() {
  const name = decodeURIComponent(location.hash.slice(1));
  const found = all.find((e) => e.name === name) || (all.length === 1 && !name ? all[0] : null);
  document.getElementById("title").textContent = found ? found.title : data.title;
  const runs = all.reduce((sum, e) => sum + e.runs.recorded, 0);
  document.getElementById("subtitle").textContent = `${plural(all.length, "experiment")}, ${plural(runs, "run")}`;
  document.title = found ? `${found.title} - ${data.title}` : data.title;
  sideOf(found ? found.name : "");
  if (found) showExperiment(content, found, list(data.worlds));
  else showOverview(content, data, go);
  window.scrollTo(0, 0);
}

const menuButton = document.getElementById("menu");
function menu(open) {
  document.body.classList.toggle("menu-open", open);
  menuButton.setAttribute("aria-expanded", String(open));
}
menuButton.addEventListener("click", () => menu(!document.body.classList.contains("menu-open")));
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") menu(false);
});
const runsDialog = document.getElementById("runs");
runsDialog.addEventListener("click", (event) => {
  if (event.target === runsDialog) runsDialog.close();
});

const wantedTheme = (location.hash.match(/theme=(dark|light)/) || [])[1];
const setTheme = (theme) => document.documentElement.setAttribute("data-theme", theme);
setTheme(wantedTheme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
if (wantedTheme) history.replaceState(null, "", location.href.replace(/[&#]?theme=(dark|light)/, ""));
document.getElementById("theme").addEventListener("click", () => setTheme(document.documentElement.getAttribute("data-theme") === "dark" ? "light" : "dark"));
window.addEventListener("hashchange", route);
route();
