// What the scripts of the page share.
const page = (() => {
  "use strict";
  // Seven bits a letter, see `packed.rs`: what HTML would read otherwise stands 128 letters further on.
  const bytesOf = (text) => {
    const bytes = new Uint8Array((text.length * 7) >> 3);
    let [held, bits, k] = [0, 0, 0];
    for (let i = 0; i < text.length; i++) {
      held = ((held << 7) | (text.charCodeAt(i) & 127)) & 0x7fff;
      bits += 7;
      if (bits < 8) continue;
      bits -= 8;
      bytes[k++] = held >> bits;
    }
    return bytes;
  };
  // The content of a packed block of the page.
  const unpacked = async (id) => {
    const packed = document.getElementById(id)?.textContent;
    if (!packed) throw new Error("this page was written without it");
    if (!("DecompressionStream" in window)) throw new Error("the browser lacks DecompressionStream");
    return new Response(new Blob([bytesOf(packed)]).stream().pipeThrough(new DecompressionStream("gzip")));
  };
  // A worker with the module in it, once there is one; it says `ready` with the names of the schemes.
  let compiled;
  const simulator = async () => {
    if (!("WebAssembly" in window) || !("Worker" in window)) throw new Error("the browser lacks WebAssembly or workers");
    compiled ??= unpacked("module").then((response) => response.arrayBuffer()).then((bytes) => WebAssembly.compile(bytes));
    const module = await compiled;
    const source = document.getElementById("worker").textContent;
    const worker = new Worker(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
    return { worker, begin: () => worker.postMessage({ module }) };
  };
  // The words of an answer, by key.
  const facts = (words) => new Map(words.split("\n").filter(Boolean).map((line) => [line.split(" ", 1)[0], line.slice(line.indexOf(" ") + 1)]));
  const make = (name, attributes = {}, ...inside) => {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.append(...inside);
    return element;
  };
  // JSON knows no infinities: the largest number stands for them.
  const restored = (value) => {
    for (const [key, inner] of Object.entries(value)) {
      if (typeof inner === "number") {
        if (Math.abs(inner) === Number.MAX_VALUE) value[key] = inner * 2;
      } else if (inner && typeof inner === "object") restored(inner);
    }
    return value;
  };
  // An object of JSON has no order; columns come as pairs in that of the table.
  const named = (study) => {
    if (!study.settings) return;
    study.settings = Object.fromEntries(study.settings), study.metrics = Object.fromEntries(study.metrics);
    for (const [row, columns] of Object.entries(study.traces)) study.traces[row] = Object.fromEntries(columns);
  };
  const data = unpacked("data").then((response) => response.json()).then((all) => {
    restored(all).studies.forEach(named);
    return all;
  });
  // What a link leads to is opened, whatever it is folded into.
  const reveal = (element) => {
    for (let outer = element; outer; outer = outer.parentElement) if (outer.tagName === "DETAILS") outer.open = true;
    element?.scrollIntoView();
  };
  const follow = () => /^#[\w-]+$/.test(location.hash) && reveal(document.getElementById(location.hash.slice(1)));
  addEventListener("hashchange", follow);
  follow();
  // Paper has no folds: what is claimed is on it, with what the reader had open.
  let unfolded = [];
  addEventListener("beforeprint", () => {
    unfolded = [...document.querySelectorAll("details.fold:not([open])")].filter((fold) => fold.querySelector(".claims,.said"));
    for (const fold of unfolded) fold.open = true;
  });
  addEventListener("afterprint", () => unfolded.forEach((fold) => (fold.open = false)));
  // A number for reading; what there is none of has a dash.
  const shown = (value, digits = 3) => {
    if (value === null || value === undefined || Number.isNaN(value)) return "–";
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
    const size = Math.abs(value);
    const text = value === 0 ? "0" : size >= 1e-3 && size < 1e5 ? String(Number(value.toPrecision(digits))) : value.toExponential(digits - 1).replace(/\.?0+e/, "e");
    return text.replaceAll("-", "−");
  };
  const copy = async (text, button) => {
    const before = button.textContent;
    try {
      await navigator.clipboard.writeText(text);
      button.textContent = "Copied";
    } catch {
      button.textContent = "Select and copy by hand";
    }
    setTimeout(() => (button.textContent = before), 1500);
  };
  const download = (name, rows) => {
    const cell = (value) => (/[",\n]/.test(String(value)) ? `"${String(value).replaceAll('"', '""')}"` : String(value ?? ""));
    const text = rows.map((row) => row.map(cell).join(",")).join("\n") + "\n";
    const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "text/csv" })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  // The other scripts are packed.
  unpacked("scripts")
    .then((response) => response.text())
    .then((text) => document.body.append(make("script", {}, text)))
    .catch((error) => {
      const note = document.getElementById("try-missing");
      note.hidden = false;
      note.textContent = `Simulating in the page is not possible here: ${error.message}. The figures and claims below stand.`;
    });
  return { reveal, unpacked, simulator, facts, make, data, shown, copy, download };
})();
