//! The style of the page: one column, readable on a phone and on paper.

pub(super) const CSS: &str = r"
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif; color: #222; background: #fff; margin: 0 auto; padding: 0 16px 48px; max-width: 1060px; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 24px 0 8px; }
h2 { font-size: 1.3rem; margin: 40px 0 8px; border-top: 2px solid #222; padding-top: 16px; }
h3 { font-size: 1.05rem; margin: 28px 0 4px; }
p { max-width: 46em; margin: 8px 0; }
.answer { font-size: 1.15rem; font-weight: 600; }
.note { color: #555; font-size: .92rem; overflow-wrap: anywhere; }
figure { margin: 12px 0; }
figure svg { max-width: 100%; height: auto; display: block; }
figure .narrow { display: none; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .92rem; margin: 8px 0; }
th, td { padding: 4px 12px 4px 0; text-align: right; white-space: nowrap; border-bottom: 1px solid #ddd; }
th.words, td.words { text-align: left; }
th { font-weight: 600; vertical-align: bottom; }
.best { font-weight: 700; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(320px, 1fr)); gap: 16px; }
.pictures figure { margin: 0; }
.pictures img { width: 100%; height: auto; image-rendering: pixelated; display: block; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 2px; }
figcaption { font-size: .88rem; color: #444; margin-top: 4px; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 2px 16px; font-size: .92rem; }
dt { color: #555; } dd { margin: 0; overflow-wrap: anywhere; }
.biased { color: #a03c00; }
@media (max-width: 640px) {
  figure .wide { display: none; }
  figure .narrow { display: block; }
  dl { grid-template-columns: 1fr; gap: 0; } dd { margin-bottom: 6px; }
  .pictures { grid-template-columns: 1fr; }
}
@media print {
  body { font-size: 11pt; max-width: none; }
  figure, tr { break-inside: avoid; }
  figure .wide { display: block; } figure .narrow { display: none; }
}
";
