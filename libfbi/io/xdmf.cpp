#include "io/xdmf.hpp"

#include "base/log.hpp"

namespace fbi::io {
namespace {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string item(const std::string& place, const char* type, int bytes, GlobalIndex rows, int columns) {
  std::string extent = std::to_string(rows);
  if (columns > 1) extent.append(" ").append(std::to_string(columns));
  return log::format("<DataItem Format=\"HDF\" NumberType=\"%s\" Precision=\"%d\" Dimensions=\"%s\">%s</DataItem>",
                     type, bytes, extent.c_str(), escaped(place).c_str());
}

std::string attributes(const std::string& file, const std::string& group, const std::vector<XdmfField>& fields,
                       GlobalIndex rows) {
  std::string text;
  for (const XdmfField& field : fields)
    text += "          <Attribute Name=\"" + escaped(field.name) + "\" AttributeType=\"" +
            (field.components == 6   ? "Tensor6"
             : field.components == 3 ? "Vector"
                                     : "Scalar") +
            "\" Center=\"Node\">" + item(file + ":/" + group + "/" + field.name, "Float", 8, rows, field.components) +
            "</Attribute>\n";
  return text;
}

}  // namespace

std::string xdmf_text(const XdmfContent& content, const std::vector<XdmfStep>& steps) {
  const std::string mesh = content.folder + "/mesh.h5";
  std::string text =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
      "    <Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const XdmfStep& step : steps) {
    const std::string file = content.folder + log::format("/%06lld.h5", static_cast<long long>(step.step));
    text += log::format("      <Grid Name=\"step %lld\" GridType=\"Collection\" CollectionType=\"Spatial\">\n",
                        static_cast<long long>(step.step));
    text += log::format("        <Time Value=\"%.17g\"/>\n", step.time);
    if (content.cells > 0) {
      text += "        <Grid Name=\"fluid\" GridType=\"Uniform\">\n";
      text += "          <Topology TopologyType=\"Hexahedron\" NumberOfElements=\"" + std::to_string(content.cells) +
              "\">" + item(mesh + ":/fluid/cells", "Int", content.integer_bytes, content.cells, 8) + "</Topology>\n";
      text += "          <Geometry GeometryType=\"XYZ\">" + item(mesh + ":/fluid/nodes", "Float", 8, content.nodes, 3) +
              "</Geometry>\n";
      text += attributes(file, "fluid", step.fluid, content.nodes);
      text += "        </Grid>\n";
    }
    if (content.fibers > 0) {
      text += "        <Grid Name=\"fibers\" GridType=\"Uniform\">\n";
      text += "          <Topology TopologyType=\"Mixed\" NumberOfElements=\"" + std::to_string(content.fibers) +
              "\">" +
              item(mesh + ":/fibers/polylines", "Int", content.integer_bytes, content.points + 2 * content.fibers, 1) +
              "</Topology>\n";
      text += "          <Geometry GeometryType=\"XYZ\">" +
              item(file + ":/fibers/position", "Float", 8, content.points, 3) + "</Geometry>\n";
      text += attributes(file, "fibers", step.fiber, content.points);
      text += "        </Grid>\n";
    }
    text += "      </Grid>\n";
  }
  return text + "    </Grid>\n  </Domain>\n</Xdmf>\n";
}

}  // namespace fbi::io
