# The Debian package: `cpack -G DEB` in a build folder of the preset `release`; scripts/package/make.sh does it all.
install(FILES ${CMAKE_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(CODE "execute_process(COMMAND gzip -9nc \"${CMAKE_CURRENT_LIST_DIR}/changelog\"
  OUTPUT_FILE \"${CMAKE_BINARY_DIR}/changelog.gz\" COMMAND_ERROR_IS_FATAL ANY)")
install(FILES ${CMAKE_BINARY_DIR}/changelog.gz DESTINATION ${CMAKE_INSTALL_DOCDIR})
# study.yaml finds ../../calibration from where it stands here, too.
install(DIRECTORY ${CMAKE_SOURCE_DIR}/data/sts-study ${CMAKE_SOURCE_DIR}/data/walk
        DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples/data)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/calibration DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)
# The Python package, where Debian's interpreter looks for it, and what there is to begin with.
install(DIRECTORY ${CMAKE_SOURCE_DIR}/apps/python/lake DESTINATION lib/python3/dist-packages PATTERN __pycache__ EXCLUDE)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/apps/python/notebooks ${CMAKE_SOURCE_DIR}/apps/python/examples/
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples/python PATTERN .ipynb_checkpoints EXCLUDE)

set(CPACK_PACKAGE_NAME lake)
set(CPACK_PACKAGE_CONTACT "lake maintainers <maintainers@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "knee exoskeletons designed from video of a sit-to-stand")
set(CPACK_PACKAGE_DESCRIPTION
  "lake tracks reflective markers in two videos of a sit-to-stand, without
and with a knee exoskeleton, fits the leg's motion, says how far the
exoskeleton's knee is from the human's and why, and finds the linkage, its
placement and the actuator's program that mend it, up to the firmware.")
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/${LAKE_LIBRARY_FOLDER})
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "snakemake (>= 7.19)")  # lake cohort
set(CPACK_DEBIAN_PACKAGE_DEPENDS "gnuplot-nox | gnuplot, fonts-dejavu-core, fonts-dejavu-extra, python3")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "python3-pandas, python3-matplotlib, python3-yaml")
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
include(CPack)
