// Contact sheet of pictures with captions.

/** Rows of `{ bytes: PNG, caption, mark: position in fractions }` as one PNG, made by a browser. */
export async function sheet(browser, rows, [width, height]) {
  const gap = 12;
  const columns = rows[0].length;
  const cell = ({ bytes, caption, mark }) => {
    const ring = mark ? `<i style="left:${100 * mark[0]}%;top:${100 * mark[1]}%"></i>` : "";
    return `<figure><div><img src="data:image/png;base64,${bytes.toString("base64")}">${ring}</div><figcaption>${caption}</figcaption></figure>`;
  };
  const page = await browser.newPage({ viewport: { width: columns * (width + gap) + gap, height: 100 } });
  await page.setContent(`<!doctype html><style>
    body { margin: 0; padding: ${gap}px; display: grid; grid-template-columns: repeat(${columns}, ${width}px); gap: ${gap}px;
      background: white; color: black; font: 15px/1.3 sans-serif }
    figure { margin: 0 }
    div { position: relative; height: ${height}px }
    img { display: block; width: ${width}px; height: ${height}px }
    i { position: absolute; width: 16px; height: 16px; margin: -10px; border: 2px solid black; border-radius: 50%; outline: 2px solid white; }
    figcaption { padding: 6px 2px 0 }
  </style>${rows.flat().map(cell).join("")}`);
  await page.evaluate(() => Promise.all([...document.images].map((image) => image.decode())));
  const bytes = await page.screenshot({ fullPage: true });
  await page.close();
  return bytes;
}
