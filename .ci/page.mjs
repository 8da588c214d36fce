// Uses the report as a reader does.
//
//   node .ci/page.mjs digits MODULE PROGRAM           every scheme in the module against the program, bit by bit (needs node alone)
//   node .ci/page.mjs browse REPORT PROGRAM [FOLDER]  drags, plays and scrubs in headless Chromium, looks for faults of
//                                                     accessibility, leaves pictures (needs puppeteer-core and axe-core; NODE_PATH)
import { execFileSync } from "node:child_process";
import { createRequire } from "node:module";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import vm from "node:vm";
import zlib from "node:zlib";

const [mode, subject, program, folder] = process.argv.slice(2);
const fail = (why) => {
  console.error(`error: ${why}`);
  process.exitCode = 1;
};
const simulate = (...options) => execFileSync(program, ["simulate", "--case", "wedge-box", ...options], { encoding: "utf8" });

async function digits() {
  // The page's own worker, outside a page.
  const source = fs.readFileSync(new URL("../crates/rimbench-figures/page/worker.js", import.meta.url), "utf8");
  let answer;
  const worker = { WebAssembly, TextEncoder, TextDecoder, Uint8Array, Float64Array, postMessage: (message) => (answer = message) };
  vm.runInNewContext(source, worker);
  const ask = async (request) => {
    await worker.onmessage({ data: { requests: [request] } });
    return answer.answers[0];
  };
  await worker.onmessage({ data: { module: zlib.gunzipSync(fs.readFileSync(subject)) } });
  const number = (text) => ({ inf: Infinity, "-inf": -Infinity, NaN: NaN })[text] ?? Number(text);
  const trace = path.join(fs.mkdtempSync(path.join(os.tmpdir(), "digits-")), "trace.csv");
  let runs = 0, equal = 0;
  for (const line of answer.ready.trim().split("\n")) {
    const scheme = line.split(" ")[1];
    for (const step of ["2e-3", "5e-3"]) {
      const own = await ask(`run\ncase wedge-box\nscheme ${scheme}\nmacro_step_s ${step}\n`);
      simulate("--scheme", scheme, "--macro-step", step, "--trace", trace);
      const [header, ...rows] = fs.readFileSync(trace, "utf8").trim().split("\n").map((row) => row.split(","));
      const columns = own.words.match(/^columns (.*)$/m)?.[1].split(" ") ?? [];
      const differs = (row, name, k) => {
        const [ours, theirs] = [own.numbers[row * columns.length + columns.indexOf(name)], number(rows[row][k])];
        return !(ours === theirs || (Number.isNaN(ours) && Number.isNaN(theirs)));
      };
      const same = rows.length * columns.length === own.numbers.length && !rows.some((_, row) => header.some((name, k) => differs(row, name, k)));
      runs += 1;
      equal += same ? 1 : 0;
      if (!same) fail(`${scheme} at ${step} s: other digits in the browser than in the program`);
    }
  }
  console.log(`${equal} of ${runs} runs have the same digits in the module and in the program`);
}

async function browse() {
  const require = createRequire(path.join(process.env.NODE_PATH ?? "", "/"));
  const { default: puppeteer } = await import(require.resolve("puppeteer-core"));
  const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(fs.existsSync);
  const browser = await puppeteer.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu"] });
  const page = await browser.newPage();
  page.on("pageerror", (error) => fail(`the page breaks off: ${error}`));
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && fail(`the console says: ${message.text()}`));
  await page.setViewport({ width: 1280, height: 1200 });
  await page.goto(`file://${path.resolve(subject)}`);
  const drawn = () => page.evaluate(() => Number(document.body.dataset.drawn ?? 0));
  const until = (count) => page.waitForFunction((count) => Number(document.body.dataset.drawn ?? 0) > count, { timeout: 120e3 }, count);
  const text = (id) => page.$eval(`#${id}`, (element) => element.textContent);
  const enter = (id, value) =>
    page.$eval(`#${id}`, (element, value) => {
      element.value = value;
      element.dispatchEvent(new Event("input", { bubbles: true }));
    }, value);
  await until(0);
  // Whatever is shown is what the program says of the same run.
  for (const [step, scheme] of [[3, "zero-order-hold"], [8, "rim-nonsmooth"], [12, "rim-smooth"]]) {
    await enter("in-b", scheme);
    const before = await drawn();
    await enter("in-h", step);
    await until(before);
    await page.waitForFunction(() => !document.body.hasAttribute("aria-busy"));
    const options = (await text("cmd-b")).match(/--scheme .*$/)[0].split(" ");
    const said = JSON.parse(simulate(...options, "--format", "json"));
    const shown = await text("cap-b");
    if (!shown.includes(said.run_id) || !shown.includes(`${said.exchanges} exchanges`)) fail(`the page shows \`${shown}\`, the program ${said.run_id}`);
  }
  // The address is written once the hand rests.
  await new Promise((resolve) => setTimeout(resolve, 500));
  if (!(await page.evaluate(() => location.hash)).includes("b=rim-smooth")) fail("the address does not say what is shown");
  await enter("in-time", 0.5);
  const pose = () => page.$eval("#box-a .world", (world) => world.getAttribute("transform"));
  const before = await pose();
  await page.click("#play");
  await new Promise((resolve) => setTimeout(resolve, 500));
  await page.click("#play");
  if (before === (await pose())) fail("playing moves nothing");
  const curve = await (await page.$("#curve")).boundingBox();
  await page.mouse.move(curve.x + 0.3 * curve.width, curve.y + 0.5 * curve.height);
  await page.mouse.down();
  await page.mouse.move(curve.x + 0.7 * curve.width, curve.y + 0.5 * curve.height);
  await page.mouse.up();
  if (!/^1\.[67]/.test(await text("out-time"))) fail(`dragging the curve to 1.7 s leads to ${await text("out-time")}`);
  await page.addScriptTag({ path: require.resolve("axe-core") });
  for (const scheme of ["light", "dark"]) {
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    const found = await page.evaluate(async () => (await window.axe.run()).violations.map((violation) => `${violation.id}: ${violation.nodes[0].html}`));
    found.forEach((violation) => fail(`${scheme}: ${violation}`));
    for (const width of [390, 820, 1440]) {
      await page.setViewport({ width, height: 1200 });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      if (wide > 0) fail(`at ${width} px the page is ${wide} px too wide`);
      if (folder) await (await page.$("#try")).screenshot({ path: path.join(folder, `try-${scheme}-${width}.png`) });
    }
  }
  await browser.close();
  console.log("the page was used and looked at");
}

await { digits, browse }[mode]();
