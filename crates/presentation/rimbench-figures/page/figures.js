// Figures that answer: exact values on hover and by arrow keys, one highlight of a series across all figures, the data behind each.
(async () => {
  "use strict";
  const { make, shown } = page;
  let figures, pictures;
  try {
    ({ figures, svg: pictures = {} } = await page.data);
  } catch {
    return; // The figures stand as they are.
  }

  // ---- one highlight, by one rule of style: figures that are not there yet obey it as well
  const select = document.getElementById("highlight");
  const rule = document.head.appendChild(make("style"));
  let pinned = "";
  const light = (name) => {
    document.body.classList.toggle("lit", Boolean(name));
    rule.textContent = name ? `.lit g.series[data-series="${CSS.escape(name)}"]{opacity:1}` : "";
  };
  const names = [...new Set(Object.values(figures).flatMap((panels) => panels.flatMap((panel) => panel[3].map(([name]) => name))))];
  if (select) {
    select.append(...names.filter(Boolean).sort().map((name) => new Option(name, name)));
    select.addEventListener("change", () => light((pinned = select.value)));
    select.closest("[hidden]").hidden = false;
  }
  const tip = document.body.appendChild(make("div", { id: "tip", role: "status", hidden: "" }));

  // Makes one figure alive, when it comes near.
  const begin = (figure) => {
    if (figure.dataset.alive) return;
    figure.dataset.alive = "yes";
    const id = figure.id.replace("figure-", "");
    if (figure.matches(".packed")) figure.querySelector(".canvas").innerHTML = pictures[id] ?? "";
    const panels = figures[id] ?? [];
    const points = panels.flatMap(([title, x, y, all]) =>
      all.flatMap(([name, , list]) =>
        list.map(([across, up, low, high, left, top, note]) => ({ title, x, y, name, across, up, low, high, left, top, note })),
      ),
    );
    if (!points.length) return;
    const canvas = figure.querySelector(".canvas"), svg = canvas.querySelector("svg");
    const [, , width, height] = svg.getAttribute("viewBox").split(" ").map(Number);
    const seen = points.filter((point) => point.left !== null && point.left !== undefined);
    const ring = svg.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "circle"));
    for (const [key, value] of Object.entries({ r: 6, fill: "none", stroke: "#c2185b", "stroke-width": 1.6, visibility: "hidden" })) ring.setAttribute(key, value);
    let at = -1;
    const hide = () => {
      ring.setAttribute("visibility", "hidden");
      tip.hidden = true;
      light(pinned);
    };
    const show = (point) => {
      ring.setAttribute("cx", point.left);
      ring.setAttribute("cy", point.top);
      ring.setAttribute("visibility", "visible");
      const range = point.low !== null && point.low !== undefined ? ` [${shown(point.low)} … ${shown(point.high)}]` : "";
      const value = point.up === null ? "no value" : `${shown(point.up, 4)}${range}`;
      tip.replaceChildren(make("strong", {}, point.name), make("br"), `${point.x}: ${shown(point.across, 4)}`, make("br"), `${point.y}: ${value}`);
      if (point.note) tip.append(make("br"), point.note);
      const box = svg.getBoundingClientRect();
      tip.hidden = false;
      const left = box.left + (point.left / width) * box.width, top = box.top + (point.top / height) * box.height;
      tip.style.left = `${Math.max(4, Math.min(left + 12, innerWidth - tip.offsetWidth - 8)) + scrollX}px`;
      tip.style.top = `${(top + tip.offsetHeight + 24 > innerHeight ? top - tip.offsetHeight - 10 : top + 12) + scrollY}px`;
      light(point.name);
    };
    canvas.addEventListener("pointermove", (event) => {
      if (figure.matches(".moved")) return hide();
      const box = svg.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * width, y = ((event.clientY - box.top) / box.height) * height;
      const legend = event.target.closest?.("g.series");
      let best = -1, least = 18;
      seen.forEach((point, k) => {
        const distance = Math.hypot(point.left - x, point.top - y);
        if (distance < least) [best, least] = [k, distance];
      });
      if (best >= 0) return show(seen[(at = best)]);
      hide();
      if (legend) light(legend.dataset.series);
    });
    canvas.addEventListener("pointerleave", hide);
    canvas.addEventListener("click", (event) => {
      const name = at >= 0 && !tip.hidden ? seen[at].name : event.target.closest?.("g.series")?.dataset.series;
      pinned = !name || name === pinned ? "" : name;
      if (select) select.value = pinned;
      light(pinned);
    });
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "group");
    canvas.setAttribute("aria-label", `${svg.querySelector("title").textContent || id}. Arrow keys go from value to value.`);
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (event.key === "Escape") hide();
      if (!step || !seen.length || figure.matches(".moved")) return;
      event.preventDefault();
      at = (at + step + seen.length) % seen.length;
      show(seen[at]);
    });
    canvas.addEventListener("blur", hide);

    // ---- the data behind it
    const head = ["panel", "series", "x", "value", "least", "most", "remark"];
    const rows = () => points.map((point) => [point.title, point.name, point.across, point.up, point.low, point.high, point.note ?? ""]);
    const details = make("details", {}, make("summary", {}, `Data of this figure (${points.length} values)`));
    details.addEventListener("toggle", () => {
      if (!details.open || details.querySelector("table")) return;
      const quantity = (title) => panels.filter((panel) => panel[0] === title).map(([, x, y]) => `${y} against ${x}`)[0];
      const body = rows().map((row) => make("tr", {}, ...row.map((value, k) => make("td", {}, typeof value === "number" || value === null ? (k > 3 && value === null ? "" : shown(value, 5)) : (value ?? "")))));
      const list = make("ul", {}, ...[...new Set(panels.map((panel) => panel[0]))].map((title) => make("li", {}, `${title || id}: ${quantity(title)}`)));
      const thinned = panels.some((panel) => panel[3].some(([, every]) => every > 1));
      const table = make("table", { class: "numbers" }, make("thead", {}, make("tr", {}, ...head.map((name) => make("th", {}, name)))), make("tbody", {}, ...body));
      details.append(list, ...(thinned ? [make("p", { class: "soft" }, "Long series are thinned here; the files have every row.")] : []), make("div", { class: "table tall", tabindex: "0", role: "region", "aria-label": `Data of ${id}` }, table));
    });
    const save = make("button", { type: "button" }, "CSV");
    save.setAttribute("aria-label", `Download the data of ${id} as CSV`);
    save.addEventListener("click", () => page.download(`${id}.csv`, [head, ...rows().map((row) => row.map((value) => (value === undefined ? "" : value)))]));
    figure.append(make("div", { class: "tools" }, details, save));
  };
  const all = document.querySelectorAll("figure.plot");
  const near = new IntersectionObserver((seen) => seen.filter((entry) => entry.isIntersecting).forEach((entry) => begin(entry.target)), { rootMargin: "1500px" });
  all.forEach((figure) => near.observe(figure));
  addEventListener("beforeprint", () => all.forEach(begin));
  document.body.dataset.figures = "ready";
})();
