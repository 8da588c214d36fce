// Formulas of the book as MathML, which browsers show without a script or a font of the page. Needs katex (NODE_PATH).
//
//   node .ci/math.mjs               preprocessor of mdBook: ```math blocks and `$…$` of every chapter
//   node .ci/math.mjs check FILE…   names every formula that is none
import { createRequire } from "node:module";
import fs from "node:fs";

const katex = createRequire(import.meta.url)("katex");
const formula = (tex, displayMode) =>
  katex.renderToString(tex, { displayMode, output: "mathml", throwOnError: true, strict: "ignore" });

// Code is left alone; a formula in a line is `$…$` in backquotes inside dollars, as forges read it: $`…`$.
function rendered(text) {
  const blocks = text.replace(/^```math\n([\s\S]*?)^```$/gm, (_, tex) => `${formula(tex, true).replaceAll("\n", " ")}\n`);
  const parts = blocks.split(/(^```[\s\S]*?^```$)/gm);
  return parts.map((part) => (part.startsWith("```") ? part : part.replace(/\$`([^`\n]+)`\$/g, (_, tex) => formula(tex, false)))).join("");
}

if (process.argv[2] === "check") {
  for (const file of process.argv.slice(3)) {
    try {
      rendered(fs.readFileSync(file, "utf8"));
    } catch (error) {
      console.error(`error: ${file}: ${error.message}`);
      process.exitCode = 1;
    }
  }
} else if (process.argv[2] !== "supports") {
  const [, book] = JSON.parse(fs.readFileSync(0, "utf8"));
  const visit = (items) => {
    for (const { Chapter: chapter } of items) {
      if (chapter) {
        chapter.content = rendered(chapter.content);
        visit(chapter.sub_items);
      }
    }
  };
  visit(book.items ?? book.sections);
  process.stdout.write(JSON.stringify(book));
}
