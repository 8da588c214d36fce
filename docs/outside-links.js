// mdBook turns every link to a `.md` file into one to an `.html` file, also where that file is no page of the book
// (METHODOLOGY.md, an experiment's README). Links that lead out of the book get their own names back, but for the page of
// the paper, whose name ends in `.html`.
(function () {
    const book = new URL(typeof path_to_root === "string" && path_to_root ? path_to_root : "./", document.baseURI).href;
    for (const link of document.querySelectorAll("main a[href]")) {
        const target = new URL(link.getAttribute("href"), document.baseURI);
        const outside = target.origin === new URL(book).origin && !target.href.startsWith(book);
        if (outside && target.pathname.endsWith(".html") && !target.pathname.endsWith("/report.html")) {
            target.pathname = target.pathname.replace(/\.html$/, ".md");
            link.href = target.href;
        }
    }
})();
