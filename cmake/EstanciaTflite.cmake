# The TFLite reader: flatc turns our reduced schema into a header; the graph becomes an ONNX model in memory.
find_package(FlatBuffers REQUIRED)
find_package(ONNX REQUIRED)
find_package(Protobuf REQUIRED)

set(tflite_schema ${PROJECT_SOURCE_DIR}/estancia/label/tflite.fbs)
set(tflite_folder ${PROJECT_BINARY_DIR}/generated)
add_custom_command(
  OUTPUT ${tflite_folder}/tflite_generated.h
  COMMAND flatbuffers::flatc --cpp --scoped-enums -o ${tflite_folder} ${tflite_schema}
  DEPENDS ${tflite_schema}
  VERBATIM)
target_sources(estancia PRIVATE ${tflite_folder}/tflite_generated.h)
file(MAKE_DIRECTORY ${tflite_folder})
target_include_directories(estancia SYSTEM PRIVATE ${tflite_folder})
target_link_libraries(estancia PRIVATE onnx onnx_proto protobuf::libprotobuf)
