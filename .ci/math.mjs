// Formulas of the book as MathML, which browsers show without a script or a font of the page. Needs katex (NODE_PATH).
//
//   node .ci/math.mjs               preprocessor of mdBook: ```math blocks and `$…$` of every chapter
//   node .ci/math.mjs check FILE…   names every formula that is none, or that is text
import { createRequire } from "node:module";
import fs from "node:fs";

const katex = createRequire(import.meta.url)("katex");
const formula = (tex, displayMode) =>
  plain(apart(aligned(katex.renderToString(tex, { displayMode, output: "mathml", throwOnError: true, strict: "ignore" }))));

// Without a font for mathematics Chromium draws an accent across its letter, and a bar over F cannot be seen.
const apart = (mathml) => mathml.replace(/<mo[^>]*>(?=[ˉ˙¨^~ˇ]<)/g, '<mo style="padding-bottom:0.15em">');

// What Markdown would read as emphasis, strikes, code, links or escapes (the tilde over a letter is such) becomes an entity.
const plain = (mathml) => mathml.replace(/[\\~_*`[\]]/g, (sign) => `&#${sign.charCodeAt(0)};`);

// Chromium knows no `columnalign`, and centres every column of an `aligned`.
function aligned(mathml) {
  const tables = [];
  return mathml.replace(/<mtable[^>]*>|<\/mtable>|<mtr>|<mtd>/g, (tag) => {
    const table = tables.at(-1);
    if (tag === "</mtable>") tables.pop();
    else if (tag === "<mtr>") table.column = 0;
    else if (tag !== "<mtd>") tables.push({ column: 0, pairs: tag.includes('columnalign="right left') });
    else if (table.pairs) {
      const [right, first] = [table.column % 2 === 0, table.column === 0];
      table.column += 1;
      return `<mtd style="text-align:${right ? "right" : "left"};padding:0.2em 0 0.2em ${right && !first ? "1.5em" : "0"}">`;
    }
    return tag;
  });
}

// Code is left alone; a formula in a line is `$…$` in backquotes inside dollars, as forges read it: $`…`$.
function rendered(text) {
  const blocks = text.replace(/^```math\n([\s\S]*?)^```$/gm, (_, tex) => `${formula(tex, true).replaceAll("\n", " ")}\n`);
  const parts = blocks.split(/(^```[\s\S]*?^```$)/gm);
  return parts.map((part) => (part.startsWith("```") ? part : part.replace(/\$`([^`\n]+)`\$/g, (_, tex) => formula(tex, false)))).join("");
}

if (process.argv[2] === "check") {
  for (const file of process.argv.slice(3)) {
    try {
      const text = fs.readFileSync(file, "utf8");
      rendered(text);
      const [, line] = text.match(/^```text\n(?:(?!```).*\n)*?(.*[⁺⁻ᵀ⟂≤≥Σ√∫½].*)$/mu) ?? [];
      if (line) throw new Error(`a formula as text: ${line.trim()}`);
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
